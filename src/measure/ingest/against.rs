//! Other readers: programs that decode the same file between our runs.

use std::{
    ffi::OsStr,
    path::Path,
    process::{Command, Stdio},
    str::FromStr,
    time::Instant,
};

use serde::Serialize;

use super::IngestError;

/// A command line whose last argument will be the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AgainstCommand {
    /// As the user typed it.
    pub text: String,
    words: Vec<String>,
}

impl FromStr for AgainstCommand {
    type Err = String;

    /// Splits at spaces; quotes, single or double, keep a word together. No shell is involved.
    fn from_str(text: &str) -> Result<AgainstCommand, String> {
        let mut words: Vec<String> = Vec::new();
        let (mut word, mut quote): (Option<String>, Option<char>) = (None, None);
        for c in text.chars() {
            match quote {
                Some(q) if c == q => quote = None,
                Some(_) => word.get_or_insert_default().push(c),
                None if c == '"' || c == '\'' => {
                    quote = Some(c);
                    word.get_or_insert_default();
                }
                None if c.is_whitespace() => words.extend(word.take()),
                None => word.get_or_insert_default().push(c),
            }
        }
        if let Some(quote) = quote {
            return Err(format!("the quote {quote} is not closed in `{text}`"));
        }
        words.extend(word);
        if words.first().is_none_or(String::is_empty) {
            return Err("expected a command, such as \"python3 reader.py\"".into());
        }
        Ok(AgainstCommand { text: text.into(), words })
    }
}

/// One run of another reader.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AgainstSample {
    /// As it printed on its last line: without its start-up.
    pub secs: f64,
    /// Processor time of the same, as it printed on a line `processor SECONDS`, if it did.
    pub processor_secs: Option<f64>,
    /// From starting the program to its end.
    pub wall_secs: f64,
    /// As it printed on a line `points N`, if it did.
    pub points: Option<u64>,
}

impl AgainstCommand {
    /// Runs it on a file of `points` points.
    ///
    /// # Errors
    /// If it cannot be started, fails, prints no seconds, or counts other points than ours.
    pub fn run(&self, file: &Path, points: u64) -> Result<AgainstSample, IngestError> {
        let fault = |what: String| IngestError::Against { command: self.text.clone(), file: file.into(), what };
        let start = Instant::now();
        let output = Command::new(&self.words[0])
            .args(self.words[1..].iter().map(OsStr::new))
            .arg(file)
            .stdin(Stdio::null())
            .output()
            .map_err(|error| fault(format!("it cannot be started: {error}")))?;
        let wall_secs = start.elapsed().as_secs_f64();
        let last = |bytes: &[u8]| {
            let text = String::from_utf8_lossy(bytes);
            text.lines().map(str::trim).rfind(|line| !line.is_empty()).unwrap_or_default().to_owned()
        };
        if !output.status.success() {
            let said = last(&output.stderr);
            let said = if said.is_empty() { "it said nothing".into() } else { format!("it said: {said}") };
            return Err(fault(format!("it failed ({}); {said}", output.status)));
        }
        let line = last(&output.stdout);
        let secs = line.parse().ok().filter(|secs: &f64| secs.is_finite() && *secs > 0.0);
        let Some(secs) = secs else {
            return Err(fault(format!("expected seconds above 0 on the last line of its output, found `{line}`")));
        };
        let text = String::from_utf8_lossy(&output.stdout);
        let counted = text.lines().find_map(|line| line.trim().strip_prefix("points ")?.trim().parse().ok());
        if let Some(other) = counted.filter(|&n: &u64| n != points) {
            return Err(fault(format!("it read {other} points, this program {points}: no comparison")));
        }
        let processor = text.lines().find_map(|line| line.trim().strip_prefix("processor ")?.trim().parse().ok());
        let processor_secs = processor.filter(|secs: &f64| secs.is_finite() && *secs > 0.0);
        Ok(AgainstSample { secs, processor_secs, wall_secs, points: counted })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Result<Vec<String>, String> {
        text.parse().map(|command: AgainstCommand| command.words)
    }

    #[test]
    fn words_are_split_as_a_shell_would() {
        assert_eq!(words("python3  a.py --x").unwrap(), ["python3", "a.py", "--x"]);
        assert_eq!(words("'my reader' \"a b\"c ''").unwrap(), ["my reader", "a bc", ""]);
        for wrong in ["", "  ", "a 'b", "'' x"] {
            assert!(words(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    #[cfg(unix)]
    fn only_seconds_on_the_last_line_count() {
        let run = |script: &str| {
            let command: AgainstCommand = format!("sh -c \"{script}\"").parse().unwrap();
            command.run(Path::new("a.las"), 5).map_err(|error| error.to_string())
        };
        let sample = run("echo 7; echo points 5; echo 0.25; echo").unwrap();
        assert_eq!((sample.secs, sample.points), (0.25, Some(5)));
        assert!(sample.wall_secs > 0.0);
        let bare = run("echo 1").unwrap();
        assert_eq!((bare.points, bare.processor_secs), (None, None));
        assert_eq!(run("echo processor 0.5; echo 1").unwrap().processor_secs, Some(0.5));
        assert_eq!(run("echo processor -1; echo 1").unwrap().processor_secs, None);
        for (script, words) in [
            ("echo fast", "found `fast`"),
            ("true", "found ``"),
            ("echo -1", "above 0"),
            ("echo inf", "above 0"),
            ("echo 1; exit 3", "said nothing"),
            ("echo no such file >&2; exit 1", "it said: no such file"),
            ("echo points 4; echo 1", "4 points, this program 5"),
        ] {
            let error = run(script).unwrap_err();
            assert!(error.contains(words) && error.contains("a.las"), "{script}: {error}");
        }
        let missing: AgainstCommand = "no-such-program-at-all".parse().unwrap();
        let error = missing.run(Path::new("a.las"), 5).unwrap_err().to_string();
        assert!(error.contains("cannot be started"), "{error}");
    }
}

//! One self-contained page: no script, no font, no address elsewhere.

use std::fmt::Write;

/// A table of text; columns after the first are numbers, and stand on the right.
#[derive(Debug, Clone, Default)]
pub struct Table {
    pub title: String,
    pub columns: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    pub fn new(title: &str, columns: &[&str]) -> Table {
        Table { title: title.into(), columns: columns.iter().map(|&c| c.into()).collect(), rows: Vec::new() }
    }

    /// As Markdown, with its title as a line of text.
    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let rule: Vec<&str> = (0..self.columns.len()).map(|i| if i == 0 { "--" } else { "--:" }).collect();
        let mut out = format!("{}\n\n{}|{}|\n", self.title, line(&self.columns), rule.join("|"));
        self.rows.iter().for_each(|row| out.push_str(&line(row)));
        out
    }

    pub fn html(&self) -> String {
        let line = |tag: &str, cells: &[String]| {
            let cells: Vec<String> = cells.iter().map(|c| format!("<{tag}>{}</{tag}>", escape(c))).collect();
            format!("<tr>{}</tr>\n", cells.concat())
        };
        let rows: String = self.rows.iter().map(|row| line("td", row)).collect();
        let (title, head) = (escape(&self.title), line("th", &self.columns));
        format!("<div class=\"wide\"><table>\n<caption>{title}</caption>\n{head}{rows}</table></div>\n")
    }
}

/// A whole page around `body`.
pub fn page(title: &str, body: &str) -> String {
    let title = escape(title);
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write!(
        out,
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>{title}</title>\n<style>\n{STYLE}</style>\n\
         </head>\n<body>\n<h1>{title}</h1>\n{body}</body>\n</html>\n"
    );
    out
}

const STYLE: &str = "\
:root { color-scheme: light dark; }
body { font: 15px/1.45 system-ui, sans-serif; max-width: 84em; margin: 2em auto; padding: 0 1em; }
h1, h2 { font-weight: 600; } h2 { margin-top: 2em; border-bottom: 1px solid #8886; overflow-wrap: anywhere; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: 1em 0; font-variant-numeric: tabular-nums; }
caption { text-align: left; font-weight: 600; padding: .3em 0; }
th, td { padding: .2em .8em; text-align: right; border-bottom: 1px solid #8884; vertical-align: bottom; }
th { font-weight: 600; max-width: 12em; } th:first-child, td:first-child { text-align: left; }
.charts { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 30em), 1fr)); gap: 1em; }
figure { margin: 0; } figcaption { font-weight: 600; } figure svg { width: 100%; height: auto; }
figure ul { list-style: none; margin: 0; padding: 0; display: flex; flex-wrap: wrap; gap: .1em 1.4em; font-size: 90%; }
figure i { display: inline-block; width: 1.8em; margin-right: .5em; vertical-align: middle; }
pre { white-space: pre-wrap; overflow-wrap: anywhere; background: #8882; padding: .6em; }
";

/// Text that is safe inside elements and attributes.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_file_is_called_cannot_break_the_page() {
        let mut table = Table::new("t", &["file", "points"]);
        table.rows.push(vec!["<b>&\"".into(), "1".into()]);
        assert!(table.html().contains("<td>&lt;b&gt;&amp;&quot;</td><td>1</td>"));
        assert!(page("<x>", "").contains("<title>&lt;x&gt;</title>"));
        assert_eq!(table.markdown(), "t\n\n| file | points |\n|--|--:|\n| <b>&\" | 1 |\n");
    }
}

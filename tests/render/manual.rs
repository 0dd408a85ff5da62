//! The manual pages and the completions, which the command line writes of itself.

use crate::bench::Bench;

/// Options that `--help` of a command lists.
fn options(bench: &Bench, command: &str) -> Vec<String> {
    let help = String::from_utf8(bench.run(&format!("{command} --help")).expect(0).stdout).unwrap();
    let lines = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
    let long = lines.filter_map(|line| line.split([' ', ',', '=', '[']).find(|word| word.starts_with("--")));
    long.map(str::to_owned).collect()
}

/// Commands that `--help` lists.
fn commands(bench: &Bench) -> Vec<String> {
    let help = String::from_utf8(bench.run("--help").expect(0).stdout).unwrap();
    let list = help.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let names = list.lines().filter(|line| !line.starts_with("    ")).filter_map(|line| line.split_whitespace().next());
    names.filter(|name| *name != "help").map(str::to_owned).collect()
}

#[test]
fn there_is_a_page_for_every_command_with_all_of_its_options() {
    let bench = Bench::new();
    bench.run("man pages/deep").expect(0);
    let all = commands(&bench);
    assert!(all.len() > 10 && all.contains(&"render".to_owned()), "{all:?}");
    let page_of = |name: &str| std::fs::read_to_string(bench.path(&format!("pages/deep/{name}.1"))).unwrap();
    let mut checked = 0;
    for name in all.iter().map(String::as_str).chain([""]) {
        let page = page_of(format!("firstlight-{name}").trim_end_matches('-')).replace("\\-", "-");
        for option in options(&bench, name) {
            assert!(page.contains(&option), "{name}: no {option} in the page");
            checked += 1;
        }
        assert!(page.contains("Examples:"), "{name}");
    }
    assert!(checked > 80, "{checked}");
    let printed = String::from_utf8(bench.run("man").expect(0).stdout).unwrap();
    assert_eq!(printed, page_of("firstlight"));
    bench.write("file", "");
    let run = bench.run("man file").expect(5);
    assert!(run.messages()[0].contains("cannot write file"), "{}", run.stderr);
}

#[test]
fn completions_name_every_command_and_option() {
    let bench = Bench::new();
    let all = commands(&bench);
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = String::from_utf8(bench.run(&format!("completions {shell}")).expect(0).stdout).unwrap();
        for name in &all {
            assert!(script.contains(name.as_str()), "{shell}: no {name}");
        }
        for option in options(&bench, "render") {
            // fish leaves the hyphens out.
            let word = if shell == "fish" { format!("-l {}", &option[2..]) } else { option };
            assert!(script.contains(&word), "{shell}: no {word}");
        }
    }
    let bash = String::from_utf8(bench.run("completions bash").expect(0).stdout).unwrap();
    let render = bash.rsplit("firstlight__subcmd__render)").next().unwrap().split("esac").next().unwrap();
    let offered = |option: &str| {
        let of = render.split(&format!("{option})\n")).nth(1).unwrap_or_else(|| panic!("no {option} in {render}"));
        of.lines().next().unwrap().trim().to_owned()
    };
    for (option, names) in [("--color-map", "viridis plasma"), ("--color-by", "auto rgb"), ("--decorate", "box scale")]
    {
        assert!(offered(option).contains(names), "{option}: {}", offered(option));
    }
    assert!(!offered("--size").contains("-f") && offered("--camera").contains("-f"), "{}", offered("--size"));
    let run = bench.run("completions tcsh").expect(2);
    assert!(run.stderr.contains("bash") && run.stderr.contains("powershell"), "{}", run.stderr);
}

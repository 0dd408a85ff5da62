//! What the keys and the mouse do: one table, which input follows and the cheat sheet shows.

use eframe::egui::{Context, Event, Key, Modifiers};

use super::{navigation::StandardView, tools::Tool};

/// What a key asks for, once per press.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    Show(StandardView),
    /// Perspective or orthographic.
    ToggleProjection,
    Undo,
    Redo,
    /// What is under the cursor comes to the middle.
    Center,
    /// The mouse looks around instead of turning the scene, or turns it again.
    FlyMode,
    /// Keeps the camera as a new bookmark.
    AddBookmark,
    /// Goes to the bookmark with this number.
    GoToBookmark(usize),
    /// Keeps the camera as the bookmark with this number.
    SetBookmark(usize),
    Take(Tool),
    /// As a click at the cursor.
    Click,
    /// Ends the line that is being measured.
    Finish,
    /// Takes away what was added last.
    Remove,
    /// Copies the last card or measurement as text.
    Copy,
    /// Puts away what is on top: help, a line that is being measured, the last card.
    Close,
    SmallerPoints,
    LargerPoints,
    ToggleLighting,
    ToggleQuality,
    ToggleBar,
    ToggleHelp,
}

/// Where the cheat sheet lists it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Section {
    Move,
    Inspect,
    Show,
    Files,
    Window,
}

impl Section {
    pub const ALL: [Section; 5] = [Section::Move, Section::Inspect, Section::Show, Section::Files, Section::Window];

    pub fn title(self) -> &'static str {
        match self {
            Section::Move => "Move",
            Section::Inspect => "Inspect",
            Section::Show => "Look",
            Section::Files => "Files and pictures",
            Section::Window => "Window",
        }
    }
}

/// One line of the cheat sheet.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    pub section: Section,
    pub keys: &'static str,
    pub what: &'static str,
    presses: &'static [(Press, Command)],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Press {
    key: Key,
    /// Ctrl, or ⌘ on a Mac.
    command: bool,
    /// `None`: where a key needs Shift depends on the keyboard.
    shift: Option<bool>,
}

const fn plain(key: Key) -> Press {
    Press { key, command: false, shift: Some(false) }
}

const fn shift(key: Key) -> Press {
    Press { key, command: false, shift: Some(true) }
}

const fn sign(key: Key) -> Press {
    Press { key, command: false, shift: None }
}

const fn ctrl(key: Key) -> Press {
    Press { key, command: true, shift: Some(false) }
}

const fn ctrl_shift(key: Key) -> Press {
    Press { key, command: true, shift: Some(true) }
}

/// Keys of the first nine bookmarks.
const DIGITS: [Key; 9] =
    [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];

const fn bookmarks<const SET: bool>() -> [(Press, Command); 9] {
    let mut presses = [(plain(Key::Num1), Command::AddBookmark); 9];
    let mut at = 0;
    while at < 9 {
        presses[at] = if SET {
            (ctrl_shift(DIGITS[at]), Command::SetBookmark(at + 1))
        } else {
            (ctrl(DIGITS[at]), Command::GoToBookmark(at + 1))
        };
        at += 1;
    }
    presses
}

const fn row(section: Section, keys: &'static str, what: &'static str, presses: &'static [(Press, Command)]) -> Row {
    Row { section, keys, what, presses }
}

/// All of it. Rows without presses are the mouse's, and of keys that are held.
pub const ROWS: &[Row] = &[
    row(Section::Move, "Left drag", "orbit around what is under the cursor", &[]),
    row(Section::Move, "Right or middle drag, Shift+left", "pan: the grabbed point follows", &[]),
    row(Section::Move, "Ctrl+left drag", "look around", &[]),
    row(Section::Move, "Wheel, pinch, Page Up, Page Down", "zoom to the cursor", &[]),
    row(Section::Move, "Double click, C", "what is there comes to the middle", &[(plain(Key::C), Command::Center)]),
    row(Section::Move, "W A S D, Q E", "fly forward, left, back, right, down, up", &[]),
    row(Section::Move, "Arrows", "orbit", &[]),
    row(Section::Move, "Shift with these", "five times as fast", &[]),
    row(
        Section::Move,
        "F",
        "left drag looks around instead of orbiting, or orbits again",
        &[(plain(Key::F), Command::FlyMode)],
    ),
    row(
        Section::Move,
        "Home, H",
        "show all",
        &[(plain(Key::Home), Command::Show(StandardView::Home)), (plain(Key::H), Command::Show(StandardView::Home))],
    ),
    row(Section::Move, "Z", "show all from this side", &[(plain(Key::Z), Command::Show(StandardView::Fit))]),
    row(
        Section::Move,
        "7, 8",
        "from above, from below",
        &[
            (plain(Key::Num7), Command::Show(StandardView::Top)),
            (plain(Key::Num8), Command::Show(StandardView::Bottom)),
        ],
    ),
    row(
        Section::Move,
        "1, 2, 3, 4",
        "from the south, the north, the east, the west",
        &[
            (plain(Key::Num1), Command::Show(StandardView::Front)),
            (plain(Key::Num2), Command::Show(StandardView::Back)),
            (plain(Key::Num3), Command::Show(StandardView::Right)),
            (plain(Key::Num4), Command::Show(StandardView::Left)),
        ],
    ),
    row(Section::Move, "5", "isometric", &[(plain(Key::Num5), Command::Show(StandardView::Isometric))]),
    row(Section::Move, "6", "with or without perspective", &[(plain(Key::Num6), Command::ToggleProjection)]),
    row(
        Section::Move,
        "Ctrl+Z, Ctrl+Y",
        "undo a camera move, and redo it",
        &[(ctrl(Key::Z), Command::Undo), (ctrl(Key::Y), Command::Redo), (ctrl_shift(Key::Z), Command::Redo)],
    ),
    row(Section::Move, "K", "keep this view as a bookmark", &[(plain(Key::K), Command::AddBookmark)]),
    row(Section::Move, "Ctrl+1 … 9", "go to a bookmark", &bookmarks::<false>()),
    row(Section::Move, "Ctrl+Shift+1 … 9", "set a bookmark to this view", &bookmarks::<true>()),
    row(Section::Inspect, "I", "inspect: a click pins a card", &[(plain(Key::I), Command::Take(Tool::Inspect))]),
    row(Section::Inspect, "M", "measure a distance", &[(plain(Key::M), Command::Take(Tool::Distance))]),
    row(Section::Inspect, "P", "measure along a line of points", &[(plain(Key::P), Command::Take(Tool::Polyline))]),
    row(
        Section::Inspect,
        "X, Shift+X",
        "clipping box, slab",
        &[(plain(Key::X), Command::Take(Tool::Box)), (shift(Key::X), Command::Take(Tool::Slab))],
    ),
    row(
        Section::Inspect,
        "Space, Enter",
        "click at the cursor; end a line of points",
        &[(plain(Key::Space), Command::Click), (plain(Key::Enter), Command::Finish)],
    ),
    row(
        Section::Inspect,
        "Backspace, Delete",
        "take away the last point, line or card",
        &[(plain(Key::Backspace), Command::Remove), (plain(Key::Delete), Command::Remove)],
    ),
    // The system's word for it, which other programs' keys give as well, comes as an event of its own.
    row(Section::Inspect, "Ctrl+C", "copy the last card or measurement", &[]),
    row(
        Section::Show,
        "[ ]  or  - =",
        "point size",
        &[
            (sign(Key::OpenBracket), Command::SmallerPoints),
            (sign(Key::Minus), Command::SmallerPoints),
            (sign(Key::CloseBracket), Command::LargerPoints),
            (sign(Key::Equals), Command::LargerPoints),
            (sign(Key::Plus), Command::LargerPoints),
        ],
    ),
    row(Section::Show, "V, Shift+V", "the next colours, the ones before", &[]),
    row(Section::Show, "L", "eye-dome lighting on or off", &[(plain(Key::L), Command::ToggleLighting)]),
    row(Section::Show, "B", "high quality (blends near points) on or off", &[(plain(Key::B), Command::ToggleQuality)]),
    row(Section::Files, "Ctrl+O", "open files", &[]),
    row(Section::Files, "Ctrl+Shift+O", "open a folder", &[]),
    row(Section::Files, "Drop files or folders", "open them instead, or besides if Add is ticked", &[]),
    row(Section::Files, "Ctrl+S", "save the picture", &[]),
    row(Section::Files, "Ctrl+Shift+C", "copy the command that makes this picture", &[]),
    row(Section::Window, "Tab", "panel on or off", &[]),
    row(Section::Window, "F6", "keyboard to the panel: then Tab, arrows, Space, Enter", &[]),
    row(
        Section::Window,
        "Esc",
        "put away what is on top; keyboard back to the picture",
        &[(plain(Key::Escape), Command::Close)],
    ),
    row(Section::Window, "O", "status lines and tools on or off", &[(plain(Key::O), Command::ToggleBar)]),
    row(
        Section::Window,
        "F1, ?",
        "this help",
        &[(plain(Key::F1), Command::ToggleHelp), (sign(Key::Questionmark), Command::ToggleHelp)],
    ),
];

/// What the keys that were pressed since the last frame ask for, in order.
pub fn pressed(ctx: &Context) -> Vec<Command> {
    ctx.input(|i| {
        // Ctrl+Shift+C is told as copying as well, but is for the whole view.
        let is_other_copy = |event: &&Event| **event == Event::Copy && i.modifiers.shift;
        i.events.iter().filter(|event| !is_other_copy(event)).filter_map(command_of).collect()
    })
}

fn command_of(event: &Event) -> Option<Command> {
    match event {
        Event::Copy => Some(Command::Copy),
        Event::Key { key, physical_key, pressed: true, modifiers, repeat } => {
            let means = |key| presses().find(|(press, _)| press.fits(key, *modifiers));
            // With Shift, and without on French keyboards, the digits' keys type something else.
            let digit = physical_key.filter(|key| DIGITS.contains(key));
            let command = means(*key).or_else(|| means(digit?))?.1;
            // A key that is held must not switch something to and fro.
            let repeats =
                matches!(command, Command::SmallerPoints | Command::LargerPoints | Command::Undo | Command::Redo);
            (!repeat || repeats).then_some(command)
        }
        _ => None,
    }
}

/// Name of the first key that asks for this, for hints beside buttons.
pub fn of(command: Command) -> Option<String> {
    let (press, _) = presses().find(|(_, other)| *other == command)?;
    let mut name = String::new();
    if press.command {
        name += "Ctrl+";
    }
    if press.shift == Some(true) {
        name += "Shift+";
    }
    Some(name + press.key.symbol_or_name())
}

fn presses() -> impl Iterator<Item = (Press, Command)> {
    ROWS.iter().flat_map(|row| row.presses.iter().copied())
}

impl Press {
    fn fits(self, key: Key, modifiers: Modifiers) -> bool {
        self.key == key
            && self.command == modifiers.command
            && !modifiers.alt
            && self.shift.is_none_or(|shift| shift == modifiers.shift)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_means_two_things_and_flying_keys_nothing_else() {
        let all: Vec<(Press, Command)> = presses().collect();
        for (at, (press, command)) in all.iter().enumerate() {
            let shifts = [false, true].map(|shift| Modifiers { shift, command: press.command, ..Modifiers::NONE });
            for modifiers in shifts.into_iter().filter(|&modifiers| press.fits(press.key, modifiers)) {
                let others = all[..at].iter().filter(|(other, _)| other.fits(press.key, modifiers));
                assert_eq!(others.count(), 0, "{press:?} ({command:?}) has another meaning");
            }
            let held = [Key::W, Key::A, Key::S, Key::D, Key::Q, Key::E, Key::ArrowUp, Key::PageUp];
            assert!(press.command || !held.contains(&press.key), "{press:?} flies");
        }
    }

    #[test]
    fn every_line_of_the_sheet_says_something_and_every_section_has_lines() {
        for row in ROWS {
            assert!(!row.keys.is_empty() && !row.what.is_empty());
        }
        for section in Section::ALL {
            assert!(ROWS.iter().any(|row| row.section == section), "{}", section.title());
        }
    }

    #[test]
    fn keys_are_told_apart_by_what_is_held_with_them() {
        let event = |key, modifiers, repeat| {
            command_of(&Event::Key { key, physical_key: None, pressed: true, repeat, modifiers })
        };
        assert_eq!(event(Key::Z, Modifiers::NONE, false), Some(Command::Show(StandardView::Fit)));
        assert_eq!(event(Key::Z, Modifiers::COMMAND, false), Some(Command::Undo));
        assert_eq!(event(Key::Z, Modifiers::COMMAND | Modifiers::SHIFT, true), Some(Command::Redo));
        assert_eq!(event(Key::Z, Modifiers::ALT, false), None);
        assert_eq!(event(Key::Num3, Modifiers::COMMAND, false), Some(Command::GoToBookmark(3)));
        assert_eq!(event(Key::Num9, Modifiers::COMMAND | Modifiers::SHIFT, false), Some(Command::SetBookmark(9)));
        let exclamation_mark = Event::Key {
            key: Key::Exclamationmark,
            physical_key: Some(Key::Num1),
            pressed: true,
            repeat: false,
            modifiers: Modifiers::COMMAND | Modifiers::SHIFT,
        };
        assert_eq!(command_of(&exclamation_mark), Some(Command::SetBookmark(1)));
        assert_eq!(event(Key::Questionmark, Modifiers::SHIFT, false), Some(Command::ToggleHelp));
        assert_eq!(event(Key::L, Modifiers::NONE, true), None, "held, it would flicker");
        assert_eq!(command_of(&Event::Copy), Some(Command::Copy));
        assert_eq!(of(Command::Redo).as_deref(), Some("Ctrl+Y"));
        assert_eq!(of(Command::Take(Tool::Slab)).as_deref(), Some("Shift+X"));
        assert_eq!(of(Command::Copy), None);
    }
}

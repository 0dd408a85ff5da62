//! What a window manager and a file manager say to a window, in X's own messages.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use x11rb::{
    CURRENT_TIME,
    connection::Connection,
    protocol::{
        Event,
        xproto::{
            AtomEnum, CLIENT_MESSAGE_EVENT, ClientMessageEvent, ConnectionExt as _, CreateWindowAux, EventMask,
            PropMode, SELECTION_NOTIFY_EVENT, SelectionNotifyEvent, Window, WindowClass,
        },
    },
    rust_connection::RustConnection,
    wrapper::ConnectionExt as _,
};

/// A connection to the display that the window is on.
pub struct XServer {
    x: RustConnection,
    root: Window,
}

impl XServer {
    pub fn connect(display: &str) -> XServer {
        let (x, screen) = x11rb::connect(Some(display)).expect("display");
        let root = x.setup().roots[screen].root;
        XServer { x, root }
    }

    /// Asks all windows that can be asked to close.
    pub fn close_windows(&self) {
        let delete = self.atom("WM_DELETE_WINDOW");
        for window in self.windows() {
            self.send(window, "WM_PROTOCOLS", [delete, 0, 0, 0, 0]);
        }
    }

    /// Drags a file over the window and lets go (XDND 5).
    pub fn drop_file(&self, file: &Path) {
        let target = *self.windows().first().expect("a window");
        let (selection, uris) = (self.atom("XdndSelection"), self.atom("text/uri-list"));
        let source = self.x.generate_id().expect("id");
        let create = CreateWindowAux::new();
        let class = WindowClass::INPUT_ONLY;
        self.x.create_window(0, source, self.root, 0, 0, 1, 1, 0, class, 0, &create).expect("window");
        self.x.set_selection_owner(source, selection, CURRENT_TIME).expect("selection");
        self.send(target, "XdndEnter", [source, 5 << 24, uris, 0, 0]);
        self.send(target, "XdndPosition", [source, 0, 300 << 16 | 300, CURRENT_TIME, self.atom("XdndActionCopy")]);
        // The window asks for what is dragged before it accepts it.
        let data = format!("file://{}\r\n", file.display());
        let began = Instant::now();
        loop {
            assert!(began.elapsed() < Duration::from_secs(60), "the window asks for no dropped files");
            match self.x.poll_for_event().expect("event") {
                Some(Event::SelectionRequest(asked)) => {
                    let write = self.x.change_property8(
                        PropMode::REPLACE,
                        asked.requestor,
                        asked.property,
                        uris,
                        data.as_bytes(),
                    );
                    write.expect("property");
                    let answer = SelectionNotifyEvent {
                        response_type: SELECTION_NOTIFY_EVENT,
                        sequence: 0,
                        time: asked.time,
                        requestor: asked.requestor,
                        selection: asked.selection,
                        target: asked.target,
                        property: asked.property,
                    };
                    self.x.send_event(false, asked.requestor, EventMask::NO_EVENT, answer).expect("answer");
                    break;
                }
                Some(_) => {}
                None => std::thread::sleep(Duration::from_millis(5)),
            }
        }
        self.send(target, "XdndDrop", [source, 0, CURRENT_TIME, 0, 0]);
    }

    fn atom(&self, name: &str) -> u32 {
        self.x.intern_atom(false, name.as_bytes()).expect("atom").reply().expect("atom").atom
    }

    /// Windows of programs: those that know how to be closed.
    fn windows(&self) -> Vec<Window> {
        let (protocols, delete) = (self.atom("WM_PROTOCOLS"), self.atom("WM_DELETE_WINDOW"));
        let mut windows = self.x.query_tree(self.root).expect("tree").reply().expect("tree").children;
        windows.retain(|&window| {
            let property = self.x.get_property(false, window, protocols, AtomEnum::ATOM, 0, 16).expect("property");
            property.reply().is_ok_and(|p| p.value32().is_some_and(|mut atoms| atoms.any(|a| a == delete)))
        });
        windows
    }

    fn send(&self, window: Window, message: &str, data: [u32; 5]) {
        let event = ClientMessageEvent {
            response_type: CLIENT_MESSAGE_EVENT,
            format: 32,
            sequence: 0,
            window,
            type_: self.atom(message),
            data: data.into(),
        };
        self.x.send_event(false, window, EventMask::NO_EVENT, event).expect("message");
        // A connection that closes too early would take the message with it.
        self.x.sync().expect("sync");
    }
}

//! The window: eframe on wgpu. It consumes the same events and records the same frames as `headless`;
//! its own are the camera in the user's hands (`navigation`) and the lines over the picture.
//!
//! Nothing is drawn while nothing changes: decoders wake the window, the picture asks for frames until
//! it has converged, and then the window sleeps.

mod app;
mod blit;
mod decor;
mod dialogs;
mod format;
mod help;
mod input;
mod keys;
mod loading;
mod messages;
mod models;
mod navigation;
mod overlay;
mod pace;
mod panels;
mod probe;
mod remembered;
mod requests;
mod rereading;
mod scene_state;
mod screenshot;
mod settings;
mod style;
mod tools;
mod touch;

use std::{path::PathBuf, sync::Arc};

use eframe::egui_wgpu::{SurfaceConfig, WgpuConfiguration, WgpuError, WgpuSetup, WgpuSetupCreateNew};

pub use remembered::SETTINGS_VARIABLE;
use remembered::Store;

use crate::render::{GpuBackend, Look, RasterChoice, RenderError};

/// What to show, and how.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Files and folders; none: an empty window that waits for a drop.
    pub inputs: Vec<PathBuf>,
    pub method: RasterChoice,
    pub look: Look,
    /// Fields of `look` that the user has given, as JSON pointers: others may be as they were remembered.
    pub given: Vec<&'static str>,
    /// Where settings are remembered; `None`: nowhere.
    pub settings: Option<PathBuf>,
    pub seed: u64,
    /// Points to try per frame; by default as many as the frame time allows.
    pub fill: Option<u32>,
    /// Decoder threads.
    pub threads: Option<usize>,
}

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    #[error("no display to open a window on: {0}")]
    NoDisplay(String),
    #[error("no GPU adapter that can draw in a window: {0}")]
    NoAdapter(String),
    #[error(transparent)]
    Render(RenderError),
}

/// Whether there is a display to try. Even then [`run`] can find none.
pub fn has_display() -> bool {
    if !cfg!(all(unix, not(target_os = "macos"))) {
        return true;
    }
    ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()))
}

/// Where settings are remembered on this platform, or where [`SETTINGS_VARIABLE`] says; `None`: nowhere.
pub fn settings_place() -> Option<PathBuf> {
    remembered::place()
}

/// Whether winit will choose Wayland.
fn is_on_wayland() -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(all(unix, not(target_os = "macos"))) && (is_set("WAYLAND_DISPLAY") || is_set("WAYLAND_SOCKET"))
}

/// Opens the window and returns when it is closed.
pub fn run(options: Options) -> Result<(), ViewError> {
    let (store, remembered) = Store::open(options.settings.clone());
    let setup = WgpuSetupCreateNew {
        device_descriptor: Arc::new(GpuBackend::device_descriptor),
        ..WgpuSetupCreateNew::without_display_handle()
    };
    let native = eframe::NativeOptions {
        viewport: eframe::egui::ViewportBuilder::default()
            .with_title("firstlight")
            .with_app_id("firstlight")
            .with_inner_size(remembered.window)
            .with_icon(eframe::egui::IconData::default())
            .with_drag_and_drop(true),
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: WgpuConfiguration {
            surface: SurfaceConfig::HIGH_THROUGHPUT,
            wgpu_setup: WgpuSetup::CreateNew(setup),
            ..Default::default()
        },
        // Points are drawn, not interpolated: noise would only change their colours.
        dithering: false,
        persist_window: false,
        ..Default::default()
    };
    let create = move |cc: &eframe::CreationContext<'_>| {
        let state = cc.wgpu_render_state.as_ref().ok_or("eframe was built without wgpu")?;
        let app = app::App::new(&cc.egui_ctx, state, options, store, remembered)?;
        Ok(Box::new(app) as Box<dyn eframe::App>)
    };
    eframe::run_native("firstlight", native, Box::new(create)).map_err(ViewError::from)
}

impl From<eframe::Error> for ViewError {
    fn from(error: eframe::Error) -> ViewError {
        match error {
            eframe::Error::Winit(error) => ViewError::NoDisplay(plain(&error.to_string())),
            eframe::Error::WinitEventLoop(error) => ViewError::NoDisplay(plain(&error.to_string())),
            eframe::Error::Wgpu(WgpuError::HandleError(error)) => ViewError::NoDisplay(plain(&error.to_string())),
            eframe::Error::Wgpu(error) => ViewError::NoAdapter(error.to_string()),
            eframe::Error::AppCreation(error) => match error.downcast::<RenderError>() {
                Ok(error) => match *error {
                    RenderError::NoAdapter(detail) => ViewError::NoAdapter(detail),
                    other => ViewError::Render(other),
                },
                Err(error) => ViewError::NoAdapter(error.to_string()),
            },
        }
    }
}

/// winit puts a place in its source before what happened.
fn plain(text: &str) -> String {
    let after_place = text.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": "));
    after_place.map_or(text, |(_, what)| what).to_owned()
}

#[cfg(test)]
mod tests {
    #[test]
    fn errors_do_not_name_source_files() {
        assert_eq!(super::plain("os error at /x/winit/mod.rs:788: no connection: refused"), "no connection: refused");
        assert_eq!(super::plain("no connection"), "no connection");
    }
}

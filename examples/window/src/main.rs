//! An eframe window that bakes inside its own frames, and draws with the light when it is there.
//!
//! ```text
//! cargo run --release --manifest-path examples/window/Cargo.toml -- scenes/cornell/scene.obj
//! ```
//!
//! With `--report FILE` it ends once the picture stands, and writes how its frames went.

mod view;

use eframe::egui;
use raycell::{Event, Flow, Params, Scene};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// What the bake may have of a frame.
const BUDGET: Duration = Duration::from_millis(8);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut path, mut report) = (PathBuf::from("scenes/cornell/scene.obj"), None);
    let mut args = std::env::args_os().skip(1);
    while let Some(arg) = args.next() {
        match arg.to_str() {
            Some("--report") => report = Some(args.next().ok_or("--report needs a file")?.into()),
            _ => path = arg.into(),
        }
    }
    let scene = Scene::load(&path)?;
    let options = eframe::NativeOptions { renderer: eframe::Renderer::Wgpu, depth_buffer: 32, ..Default::default() };
    eframe::run_native("raycell", options, Box::new(move |context| Ok(Box::new(Window::new(context, scene, report)?))))?;
    Ok(())
}

/// The window.
struct Window {
    /// What the bake said last, from its own thread.
    said: Arc<Mutex<String>>,
    /// What became of it.
    state: view::State,
    clicks: u32,
    start: Instant,
    /// When the frames began, the last of them last.
    frames: Vec<Instant>,
    /// Frames since the picture stands.
    shown: u32,
    report: Option<PathBuf>,
}

impl Window {
    fn new(
        context: &eframe::CreationContext,
        scene: Scene,
        report: Option<PathBuf>,
    ) -> Result<Window, Box<dyn std::error::Error + Send + Sync>> {
        let wgpu = context.wgpu_render_state.as_ref().ok_or("the window has no wgpu")?;
        let said = Arc::new(Mutex::new(String::new()));
        let tell = said.clone();
        // A preview: at sixty frames a second, eight milliseconds each, all rays would take their time.
        let params = Params { rays: 65_536, ..Params::default() };
        // The window's own device and queue; what is said goes to the label.
        let baker = raycell::Baker::new(&wgpu.device, &wgpu.queue, &scene, params)?.progress(move |event| {
            if let Some(text) = words(event) {
                *tell.lock().unwrap_or_else(|e| e.into_inner()) = text;
            }
            Flow::Continue
        });
        let state = view::State::default();
        let view = view::View::new(&wgpu.device, wgpu.target_format, scene, baker, state.clone());
        wgpu.renderer.write().callback_resources.insert(view);
        Ok(Window { said, state, clicks: 0, start: Instant::now(), frames: Vec::new(), shown: 0, report })
    }

    /// Writes how the frames went.
    fn report(&self, path: &PathBuf) -> std::io::Result<()> {
        let mut gaps: Vec<f64> = self.frames.windows(2).map(|w| 1e3 * (w[1] - w[0]).as_secs_f64()).collect();
        gaps.sort_by(f64::total_cmp);
        let at = |part: f64| gaps.get((part * gaps.len() as f64) as usize).or(gaps.last()).copied().unwrap_or(0.0);
        let text = format!(
            "{{\"seconds\": {:.2}, \"frames\": {}, \"median_ms\": {:.2}, \"p99_ms\": {:.2}, \"longest_ms\": {:.2}, \"clicks\": {}}}\n",
            self.start.elapsed().as_secs_f64(),
            self.frames.len(),
            at(0.5),
            at(0.99),
            at(1.0),
            self.clicks
        );
        std::fs::write(path, text)
    }
}

/// An event as a label.
fn words(event: &Event) -> Option<String> {
    Some(match event {
        Event::Stage { name } => format!("{name} ..."),
        Event::Rays { done, total } => format!("{done} of {total} rays"),
        Event::Cells { count } => format!("{count} cells"),
        Event::Sweep { n, .. } => format!("{n} sweeps"),
        Event::Points { done, total } => format!("light at {done} of {total} corners"),
        _ => return None,
    })
}

impl eframe::App for Window {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        self.frames.push(Instant::now());
        let state = self.state.lock().unwrap_or_else(|e| e.into_inner()).clone();
        egui::Panel::top("bar").show(ui, |ui| {
            ui.horizontal(|ui| {
                if ui.button(format!("clicked {} times", self.clicks)).clicked() {
                    self.clicks += 1;
                }
                match &state {
                    None => {
                        ui.spinner();
                        ui.label(self.said.lock().unwrap_or_else(|e| e.into_inner()).clone());
                    }
                    Some(Ok(())) => {
                        ui.label("baked");
                    }
                    Some(Err(why)) => {
                        ui.label(why);
                    }
                }
            });
        });
        egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| {
            let area = ui.available_rect_before_wrap();
            ui.painter().add(eframe::egui_wgpu::Callback::new_paint_callback(area, view::Slice { area }));
        });
        // The bake goes on with the next frame.
        ui.ctx().request_repaint();

        if let (Some(path), Some(result)) = (&self.report, &state) {
            self.shown += 1;
            if let Err(why) = result {
                eprintln!("window: {why}");
                std::process::exit(1);
            }
            if self.shown == 20 {
                if let Err(e) = self.report(path) {
                    eprintln!("window: {}: {e}", path.display());
                    std::process::exit(1);
                }
                ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
            }
        }
    }
}

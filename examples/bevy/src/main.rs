//! A Bevy app that bakes on Bevy's own device, a slice a frame, and shows the scene by the baked light.
//!
//! ```text
//! cargo run --release --manifest-path examples/bevy/Cargo.toml -- scenes/cornell/scene.obj picture.png
//! ```
//!
//! It opens no window, so that it runs anywhere; with `bevy_winit` among the features and a camera on the
//! window it is the same.

use bevy::app::ScheduleRunnerPlugin;
use bevy::asset::RenderAssetUsages;
use bevy::camera::RenderTarget;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::render::view::screenshot::{Screenshot, save_to_disk};
use bevy::window::ExitCondition;
use raycell::{Baked, Baker, Params, Ready, Scene};
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::Duration;

/// What the bake may have of a frame.
const BUDGET: Duration = Duration::from_millis(4);
/// What radiance is multiplied by for the eye.
const EXPOSURE: f32 = 1.0;
/// Frames for Bevy to build its pipelines before the picture is taken.
const SETTLE: u32 = 60;
/// Frames for the picture to be written.
const WRITE: u32 = 60;

/// The bake in Bevy's frames.
#[derive(Resource)]
struct Bake {
    scene: Scene,
    /// Made with the first frame, when there is a device.
    baker: Option<Mutex<Baker>>,
    frames: u32,
}

/// The picture to be taken.
#[derive(Resource)]
struct Picture {
    path: PathBuf,
    target: Handle<Image>,
    /// Frames since the light is there.
    shown: Option<u32>,
}

fn main() -> AppExit {
    let mut args = std::env::args_os().skip(1).map(PathBuf::from);
    let scene = args.next().unwrap_or("scenes/cornell/scene.obj".into());
    let path = args.next().unwrap_or("bevy.png".into());
    let scene = match Scene::load(&scene) {
        Ok(scene) => scene,
        Err(e) => {
            eprintln!("bevy: {e}");
            return AppExit::error();
        }
    };
    App::new()
        .add_plugins(DefaultPlugins.set(WindowPlugin {
            primary_window: None,
            exit_condition: ExitCondition::DontExit,
            ..default()
        }))
        .add_plugins(ScheduleRunnerPlugin::run_loop(Duration::from_millis(2)))
        .insert_resource(ClearColor(Color::BLACK))
        .insert_resource(Bake { scene, baker: None, frames: 0 })
        .insert_resource(Picture { path, target: Handle::default(), shown: None })
        .add_systems(Startup, camera)
        .add_systems(Update, (bake, picture).chain())
        .run()
}

/// Looks at the scene from its open front.
fn camera(mut commands: Commands, mut images: ResMut<Assets<Image>>, bake: Res<Bake>, mut picture: ResMut<Picture>) {
    let (mut low, mut high) = (Vec3::MAX, Vec3::MIN);
    for v in &bake.scene.vertices {
        let v = Vec3::from_array(v.map(|x| x as f32));
        (low, high) = (low.min(v), high.max(v));
    }
    let middle = 0.5 * (low + high);
    let mut image = Image::new_target_texture(512, 512, TextureFormat::Rgba8UnormSrgb, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    picture.target = images.add(image);
    commands.spawn((
        Camera3d::default(),
        RenderTarget::Image(picture.target.clone().into()),
        Tonemapping::Reinhard,
        Transform::from_translation(middle - 1.75 * (high - low).max_element() * Vec3::Z).looking_at(middle, Vec3::Y),
    ));
}

/// The bake's part of a frame: recorded into a command encoder of the app's, which the app submits.
fn bake(
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    mut bake: ResMut<Bake>,
    mut picture: ResMut<Picture>,
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut exit: MessageWriter<AppExit>,
) {
    if picture.shown.is_some() {
        return;
    }
    match slice(&device, &queue, &mut bake) {
        Ok(None) => {}
        Ok(Some(baked)) => {
            println!("baked in {} frames", bake.frames);
            let white = StandardMaterial { unlit: true, ..default() };
            commands.spawn((Mesh3d(meshes.add(mesh(&baked))), MeshMaterial3d(materials.add(white))));
            picture.shown = Some(0);
        }
        Err(e) => {
            eprintln!("bevy: {e}");
            exit.write(AppExit::error());
        }
    }
}

fn slice(device: &RenderDevice, queue: &RenderQueue, bake: &mut Bake) -> raycell::Result<Option<Baked>> {
    let slot = match bake.baker.take() {
        Some(baker) => baker,
        None => Mutex::new(Baker::new(device.wgpu_device(), queue, &bake.scene, Params::default())?),
    };
    let mut baker = slot.into_inner().unwrap_or_else(|e| e.into_inner());
    bake.frames += 1;
    let mut encoder = device.create_command_encoder(&Default::default());
    baker.encode(&mut encoder, BUDGET)?;
    queue.submit([encoder.finish()]);
    if baker.poll_ready()? == Ready::Done {
        return baker.finish().map(Some);
    }
    bake.baker = Some(Mutex::new(baker));
    Ok(None)
}

/// The lit mesh, its light as vertex colours: what a camera sees of a diffuse surface is its radiosity over pi.
fn mesh(baked: &Baked) -> Mesh {
    let vertices = &baked.mesh.vertices;
    let positions: Vec<[f32; 3]> = vertices.iter().map(|v| v.p.map(|x| x as f32)).collect();
    let normals: Vec<[f32; 3]> = vertices.iter().map(|v| v.n).collect();
    let colours: Vec<[f32; 4]> = vertices
        .iter()
        .map(|v| {
            let [r, g, b] = v.b.map(|b| EXPOSURE * b / std::f32::consts::PI);
            [r, g, b, 1.0]
        })
        .collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colours)
        .with_inserted_indices(Indices::U32(baked.mesh.faces.concat()))
}

/// Takes the picture once it stands, and ends.
fn picture(mut commands: Commands, mut picture: ResMut<Picture>, mut exit: MessageWriter<AppExit>) {
    let Some(shown) = picture.shown else { return };
    picture.shown = Some(shown + 1);
    if shown == SETTLE {
        commands.spawn(Screenshot::image(picture.target.clone())).observe(save_to_disk(picture.path.clone()));
    }
    if shown == SETTLE + WRITE {
        exit.write(AppExit::Success);
    }
}

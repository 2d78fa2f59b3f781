//! Scenes to shadow-map stacks and frames, on the CPU and through wgpu, bit for bit the same.

pub mod scene;

pub use scene::{AlphaMask, Camera, LightView, Material, Scene, Vertex};

//! Stacks on disk.

use std::fs;
use std::path::Path;

use libtest_mimic::{Failed, Trial};
use shadow_renderer::*;

use crate::compare::compare;
use crate::scenes::{Random, SLANTED, scene_of, soup};

pub fn trials() -> Vec<Trial> {
    vec![
        Trial::test("files::round_trip", round_trip),
        Trial::test("files::empty_stack", empty_stack),
        Trial::test("files::damaged_bytes", damaged_bytes),
        Trial::test("files::contradictions", contradictions),
        Trial::test("files::failed_save_leaves_nothing", failed_save_leaves_nothing),
    ]
}

fn stack(triangles: usize, size: u32) -> ShadowMapStack {
    let scene = scene_of(&soup(triangles, &mut Random(3)));
    render_stack(&scene, SLANTED, size, size + 1, Backend::Cpu).unwrap().0
}

fn names(folder: &Path) -> Vec<String> {
    fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
}

fn round_trip() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("stack.npz");
    let saved = stack(500, 60);
    saved.save(&path)?;
    compare(&saved, &ShadowMapStack::load(&path)?)?;
    let bytes = fs::read(&path)?;
    saved.save(&path)?; // replaces
    assert_eq!(bytes, fs::read(&path)?, "the same stack must give the same bytes");
    assert_eq!(names(folder.path()), ["stack.npz"]);
    Ok(())
}

fn empty_stack() -> Result<(), Failed> {
    let path = tempfile::tempdir()?.keep().join("stack.npz");
    let empty = ShadowMapStack { width: 2, height: 1, offsets: vec![0; 3], ..Default::default() };
    empty.save(&path)?;
    let loaded = ShadowMapStack::load(&path)?;
    fs::remove_dir_all(path.parent().ok_or("no folder")?)?;
    Ok(compare(&empty, &loaded)?)
}

/// Any single damaged byte, and any truncation, is an error or leaves the contents intact; nothing panics.
fn damaged_bytes() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("stack.npz");
    let saved = stack(3, 4);
    saved.save(&path)?;
    let intact = fs::read(&path)?;
    let mut refused = 0;
    for position in 0..intact.len() {
        for damage in [0x01, 0x80, 0xff] {
            let mut bytes = intact.clone();
            bytes[position] ^= damage;
            fs::write(&path, &bytes)?;
            match ShadowMapStack::load(&path) {
                Ok(loaded) => {
                    compare(&saved, &loaded).map_err(|e| format!("byte {position} ^ {damage}: {e}"))?
                }
                Err(_) => refused += 1,
            }
        }
        fs::write(&path, &intact[..position])?;
        assert!(ShadowMapStack::load(&path).is_err(), "truncated to {position} bytes");
    }
    assert!(refused > intact.len(), "only {refused} damages were noticed");
    Ok(())
}

/// Well-formed archives with wrong contents; the error names the array.
fn contradictions() -> Result<(), Failed> {
    let good = stack(50, 16);
    let (texel, first) = (0..good.offsets.len() - 1)
        .map(|t| (t, good.offsets[t] as usize))
        .find(|&(t, _)| good.offsets[t + 1] - good.offsets[t] > 1)
        .ok_or("no texel with two layers")?;
    let expect = |array: &str, fault: &dyn Fn(&mut ShadowMapStack)| {
        let mut bad = good.clone();
        fault(&mut bad);
        let message = bad.validate().expect_err(array).to_string();
        assert!(message.contains(&format!("'{array}'")), "{array}: {message}");
        let path = tempfile::tempdir().unwrap().path().join("x.npz");
        assert!(bad.save(&path).is_err(), "an invalid stack must not be saved");
    };
    expect("offsets", &|s| s.offsets[texel + 1] = u32::MAX);
    expect("offsets", &|s| *s.offsets.last_mut().unwrap() += 1);
    expect("offsets", &|s| s.offsets[0] = 1);
    expect("offsets", &|s| s.offsets.truncate(s.offsets.len() - 1));
    expect("depths", &|s| s.depths[first] = f32::NAN);
    expect("depths", &|s| s.depths[first] = 1.5);
    expect("depths", &|s| (s.depths[first], s.depths[first + 1]) = (0.75, 0.25));
    expect("gradients", &|s| s.gradients[first][0] = f32::INFINITY);
    expect("gradients", &|s| s.gradients.truncate(s.gradients.len() - 1));
    expect("light_facing", &|s| s.light_facing = s.light_facing.iter().skip(1).collect());
    assert!(matches!(
        ShadowMapStack { width: 0, ..good.clone() }.validate(),
        Err(RenderError::MapSize { width: 0, .. })
    ));
    let missing = ShadowMapStack::load(Path::new("does/not/exist.npz"));
    assert!(matches!(missing, Err(RenderError::File { .. })));
    let no_archive = ShadowMapStack::load(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")));
    assert!(matches!(no_archive, Err(RenderError::Archive { .. })));
    Ok(())
}

fn failed_save_leaves_nothing() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    // The name is taken by a folder that is not empty, so the last step fails.
    let path = folder.path().join("stack.npz");
    fs::create_dir_all(path.join("inside"))?;
    assert!(matches!(stack(3, 4).save(&path), Err(RenderError::File { .. })));
    assert_eq!(names(folder.path()), ["stack.npz"]);
    assert!(stack(3, 4).save(&folder.path().join("no/such/folder.npz")).is_err());
    Ok(())
}

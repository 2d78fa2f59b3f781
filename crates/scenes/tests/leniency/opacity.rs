//! What lets light through: transmission of glTF, `d` and `Tr` of MTL files.

use super::{UNIT, kinds, leaf};
use scenes::{LoadOptions, Scene, WarningKind, load_with_files};

#[test]
fn transmission_is_kept_beside_what_covers() {
    let of = |transmission: &str, pbr: &str, mode: &str| {
        let material = format!(
            r#""alphaMode":"{mode}","extensions":{{"KHR_materials_transmission":{transmission}}},"pbrMetallicRoughness":{{{pbr}}}"#
        );
        leaf(&material, "", UNIT, None).materials[0].clone()
    };
    let glass = of(
        r#"{"transmissionFactor":0.8}"#,
        r#""baseColorFactor":[1,0.5,0.25,0.3],"metallicFactor":0"#,
        "OPAQUE",
    );
    let opacity = glass.opacity.unwrap();
    assert_eq!((opacity.factor, opacity.tested, opacity.transmission), (1.0, true, [0.8, 0.4, 0.2]));
    assert!(glass.mask.is_none(), "glass is opaque where shadows are");
    // Metal transmits nothing, and metal is what a material is without a word.
    assert!(of(r#"{"transmissionFactor":0.8}"#, "", "OPAQUE").opacity.is_none());
    assert!(of("{}", r#""metallicFactor":0"#, "OPAQUE").opacity.is_none());
    let half =
        of(r#"{"transmissionFactor":0.5}"#, r#""baseColorFactor":[1,1,1,0.4],"metallicFactor":0"#, "BLEND");
    let opacity = half.opacity.unwrap();
    assert_eq!((opacity.factor, opacity.tested, opacity.transmission), (0.4, false, [0.5; 3]));
    // The red channel of a texture, with the coordinates of the base colour.
    let textured = of(
        r#"{"transmissionFactor":1,"transmissionTexture":{"index":0}}"#,
        r#""metallicFactor":0,"baseColorTexture":{"index":0}"#,
        "OPAQUE",
    );
    assert_eq!(textured.opacity.unwrap().transmission_texture.unwrap().alpha.len(), 4);
}

#[test]
fn transmission_that_is_none_is_told() {
    let warnings = |factor: &str| {
        let material = format!(
            r#""extensions":{{"KHR_materials_transmission":{{"transmissionFactor":{factor}}}}},"pbrMetallicRoughness":{{"metallicFactor":0}}"#
        );
        kinds(&leaf(&material, "", UNIT, None))
    };
    assert_eq!(warnings("1.5"), [WarningKind::OutOfRange]);
    assert_eq!(warnings("0.5"), []);
}

#[test]
fn opacities_of_an_mtl_outside_of_their_range_are_told() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("mtl-opacity");
    std::fs::create_dir_all(&folder).unwrap();
    let load = |statement: &str| {
        std::fs::write(folder.join("a.mtl"), format!("newmtl m\n{statement}\n")).unwrap();
        let text = "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        std::fs::write(folder.join("a.obj"), text).unwrap();
        load_with_files(folder.join("a.obj").to_str().unwrap(), &LoadOptions::default()).unwrap().0
    };
    let factor = |scene: &Scene| scene.materials[0].opacity.as_ref().map(|opacity| opacity.factor);
    for (statement, expected, count) in [
        ("d 0.25", Some(0.25), 0),
        ("Tr 0.75", Some(0.25), 0),
        ("Tr 1", None, 0),
        ("d 1.5", None, 1),
        ("d nan", None, 1),
        ("Tr -2", None, 1),
    ] {
        let scene = load(statement);
        assert_eq!((factor(&scene), scene.warnings.len()), (expected, count), "{statement}");
        if count > 0 {
            assert!(scene.warnings[0].message.contains("line 2 of \"a.mtl\""), "{}", scene.warnings[0]);
        }
    }
}

//! What places, moves and hides geometry: instances, skins, morph targets, animations, visibility, distance.

#![allow(clippy::unwrap_used, reason = "tests fail by panicking and may report")]

mod fixture;

use fixture::{Parts, assert_bounds, bounds, mesh, square};
use scenes::{LoadOptions, PoseChoice, Scene, WarningKind, load_with_files};

const IDENTITY: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// Loads with a pose, from a file of the test's own.
fn posed(name: &str, parts: &Parts, rest: &str, pose: PoseChoice) -> Result<Scene, String> {
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.gltf"));
    std::fs::write(&path, parts.json(rest)).unwrap();
    let options = LoadOptions { pose, strict: false };
    load_with_files(path.to_str().unwrap(), &options)
        .map(|(scene, _)| scene)
        .map_err(|error| error.to_string())
}

fn pose(animation: Option<&str>, time: Option<f64>) -> PoseChoice {
    PoseChoice { animation: animation.map(str::to_owned), time }
}

#[test]
fn instances_are_placed_turned_and_scaled_within_their_node() {
    let mut parts = square();
    let translations = parts.floats("VEC3", &[0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 0.0, 5.0, 0.0]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let rotations = parts.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half, 0.0, 0.0, 0.0, 1.0]);
    let scales = parts.floats("VEC3", &[1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 4.0, 4.0, 1.0]);
    let node = |attributes: String| {
        format!(
            r#""scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"translation":[100,0,0],"extensions":{{"EXT_mesh_gpu_instancing":
            {{"attributes":{{{attributes}}}}}}}}}],{}"#,
            mesh("")
        )
    };
    let all =
        format!(r#""TRANSLATION":{translations},"ROTATION":{rotations},"SCALE":{scales},"_ID":{scales}"#);
    let scene = parts.load(&node(all));
    assert_eq!(scene.triangles.len(), 3 * 2 + 2);
    // The second is turned a quarter about z, the third four times as large.
    assert_bounds(&scene, [100.0, 0.0, 0.0], [110.0, 9.0, 0.0]);
    let one = parts.load(&node(format!(r#""SCALE":{scales}"#)));
    assert_bounds(&one, [100.0, 0.0, 0.0], [104.0, 4.0, 0.0]);
    let none = parts.load(&node(String::new()));
    assert_eq!(none.triangles.len(), 2 + 2);

    let two = parts.floats("VEC3", &[0.0; 6]);
    let message = parts.refused(&node(format!(r#""TRANSLATION":{translations},"SCALE":{two}"#)));
    assert!(message.contains("nodes[0].extensions.EXT_mesh_gpu_instancing: 2 values"), "{message}");
    // A thousand million copies that take no bytes.
    let many = parts.raw(r#"{"componentType":5126,"count":1000000000,"type":"VEC3"}"#);
    let message = parts.refused(&node(format!(r#""TRANSLATION":{many}"#)));
    assert!(message.contains("1000000000 instances exceed the limit"), "{message}");
}

/// The square, its lower corners on the first joint, its upper ones on the second, which is 3 higher than it was bound.
fn skinned(weights: &[f32], joints: &[u8], more: &str) -> (Parts, String) {
    let mut parts = square();
    let joints = parts.bytes("VEC4", joints);
    let weights = parts.floats("VEC4", weights);
    let inverses = parts.floats("MAT4", &[IDENTITY, IDENTITY].concat());
    let rest = format!(
        r#""scenes":[{{"nodes":[0,1]}}],"nodes":[{{"mesh":0,"skin":0,"translation":[50,50,50]}},
        {{"children":[2],"translation":[0,0,7]}},{{"translation":[0,3,0]}}],
        "skins":[{{"joints":[1,2],"inverseBindMatrices":{inverses}}}],{}{more}"#,
        mesh(&format!(r#","JOINTS_0":{joints},"WEIGHTS_0":{weights}"#))
    );
    (parts, rest)
}

const JOINTS: [u8; 16] = [0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0];
const WEIGHTS: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0];

#[test]
fn joints_place_a_skin_and_its_own_node_does_not() {
    let (parts, rest) = skinned(&WEIGHTS, &JOINTS, "");
    let scene = parts.load(&rest);
    assert_bounds(&scene, [0.0, 0.0, 7.0], [1.0, 4.0, 7.0]);
    assert!(scene.warnings.is_empty());
    // Half of the way with half of the weight.
    let mut half = WEIGHTS;
    (half[8], half[9], half[12], half[13]) = (0.5, 0.5, 0.5, 0.5);
    let (parts, rest) = skinned(&half, &JOINTS, "");
    assert_bounds(&parts.load(&rest), [0.0, 0.0, 7.0], [1.0, 2.5, 7.0]);
    // A joint outside of the scene places it all the same.
    let (parts, rest) = skinned(&WEIGHTS, &JOINTS, "");
    assert_bounds(
        &parts.load(&rest.replace(r#""nodes":[0,1]}"#, r#""nodes":[0]}"#)),
        [0.0, 0.0, 7.0],
        [1.0, 4.0, 7.0],
    );
}

#[test]
fn weights_that_do_not_sum_to_one_are_scaled_and_told() {
    let (parts, rest) = skinned(&WEIGHTS.map(|w| 0.25 * w), &JOINTS, "");
    let scene = parts.load(&rest);
    assert_bounds(&scene, [0.0, 0.0, 7.0], [1.0, 4.0, 7.0]);
    assert_eq!((scene.warnings[0].kind, scene.warnings[0].count), (WarningKind::JointWeights, 4));
    let (parts, rest) = skinned(&[0.0; 16], &JOINTS, "");
    assert_bounds(&parts.load(&rest), [0.0, 0.0, 7.0], [1.0, 1.0, 7.0]);
}

#[test]
fn broken_skins_are_refused() {
    let refused = |weights: &[f32], joints: &[u8], from: &str, to: &str| {
        let (parts, rest) = skinned(weights, joints, "");
        assert!(rest.contains(from), "{rest}");
        parts.refused(&rest.replace(from, to))
    };
    let same = "skins";
    let mut far = JOINTS;
    far[9] = 9;
    let message = refused(&WEIGHTS, &far, same, same);
    assert!(message.contains("joint of vertex 2: index 9 is out of range, there are 2"), "{message}");
    let message = refused(&[f32::NAN; 16], &JOINTS, same, same);
    assert!(message.contains("weight NaN of a joint at vertex 0"), "{message}");
    let message = refused(&WEIGHTS, &JOINTS, r#""joints":[1,2]"#, r#""joints":[1,2,0]"#);
    assert!(message.contains("2 inverse bind matrices for 3 joints"), "{message}");
    let message = refused(&WEIGHTS, &JOINTS, r#""joints":[1,2]"#, r#""joints":[1,77]"#);
    assert!(message.contains("nodes[77]: index 77 is out of range, there are 3"), "{message}");
    let message = refused(&WEIGHTS[..12], &JOINTS, same, same);
    assert!(message.contains("3 joints or weights for 4 positions"), "{message}");
    let message = refused(&WEIGHTS, &JOINTS[..8], same, same);
    assert!(message.contains("2 joints or weights for 4 positions"), "{message}");
    // Joints in a cycle, away from the scene.
    let cycle = r#"{"children":[2],"translation":[0,0,7]},{"translation":[0,3,0],"children":[1]}"#;
    let (parts, rest) = skinned(&WEIGHTS, &JOINTS, "");
    let rest = rest.replace(r#""nodes":[0,1]}"#, r#""nodes":[0]}"#);
    let from = rest.find(r#"{"children":[2]"#).unwrap();
    let end = rest.find(r#""skins""#).unwrap();
    let looped = format!("{}{cycle}],{}", &rest[..from], &rest[end..]);
    assert!(parts.refused(&looped).contains("is its own ancestor"), "{}", parts.refused(&looped));
    let (parts, rest) = skinned(&WEIGHTS, &JOINTS, "");
    let message = parts.refused(&rest.replace(r#","WEIGHTS_0""#, r#","WEIGHTS_1""#));
    assert!(message.contains("has JOINTS_0 and no WEIGHTS_0"), "{message}");
}

/// The square with two targets, which lift its upper corners by 1 and move all by 10 along x.
fn morphed(weights: &str) -> (Parts, String) {
    let mut parts = square();
    let lift = parts.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    let aside = parts.floats("VEC3", &[10.0, 0.0, 0.0].repeat(4));
    let rest = format!(
        r#""scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],"meshes":[{{{weights}"primitives":[{{"attributes":{{"POSITION":0}},
        "indices":1,"targets":[{{"POSITION":{lift}}},{{"POSITION":{aside}}}]}}]}}]"#
    );
    (parts, rest)
}

#[test]
fn morph_targets_weigh_as_mesh_node_or_animation_say() {
    let (parts, rest) = morphed("");
    assert_bounds(&parts.load(&rest), [0.0; 3], [1.0, 1.0, 0.0]);
    let (mut parts, rest) = morphed(r#""weights":[0.5,1],"#);
    assert_bounds(&parts.load(&rest), [10.0, 0.0, 0.0], [11.0, 1.5, 0.0]);
    let of_node = rest.replace(r#"{"mesh":0}"#, r#"{"mesh":0,"weights":[3]}"#);
    assert_bounds(&parts.load(&of_node), [0.0; 3], [1.0, 4.0, 0.0]);
    let times = parts.floats("SCALAR", &[0.0, 2.0]);
    let keys = parts.floats("SCALAR", &[0.0, 0.0, 1.0, 1.0]);
    let animated = format!(
        r#"{rest},"animations":[{{"channels":[{{"sampler":0,"target":{{"node":0,"path":"weights"}}}}],
        "samplers":[{{"input":{times},"output":{keys}}}]}}]"#
    );
    let at = |time| posed("morph", &parts, &animated, pose(None, Some(time))).unwrap();
    assert_bounds(&at(0.0), [0.0; 3], [1.0, 1.0, 0.0]);
    assert_bounds(&at(0.5), [2.5, 0.0, 0.0], [3.5, 1.25, 0.0]);
    assert_bounds(&at(9.0), [10.0, 0.0, 0.0], [11.0, 2.0, 0.0]);
    let many = parts.load(&rest.replace("[0.5,1]", "[0.5,1,7]"));
    assert_eq!(many.warnings[0].kind, WarningKind::MorphWeights);
}

#[test]
fn a_million_morph_targets_are_refused_before_they_are_added_up() {
    let (mut parts, _) = morphed("");
    let vertices = 30_000;
    let long = parts.floats("VEC3", &[1.0, 2.0, 3.0].repeat(vertices));
    let (targets, weights) = (vec![format!(r#"{{"POSITION":{long}}}"#); 100_000], vec!["1"; 100_000]);
    let rest = format!(
        r#""scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],"meshes":[{{"weights":[{}],"primitives":[{{"attributes":{{"POSITION":{long}}},
        "targets":[{}]}}]}}]"#,
        weights.join(","),
        targets.join(",")
    );
    let message = parts.refused(&rest);
    assert!(message.contains("values of morph targets exceed the limit"), "{message}");
}

/// A square whose node is animated by one channel.
fn animated(path: &str, kind: &str, interpolation: &str, times: &[f32], values: &[f32]) -> (Parts, String) {
    let mut parts = square();
    let times = parts.floats("SCALAR", times);
    let values = parts.floats(kind, values);
    let rest = format!(
        r#""scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"translation":[0,0,2]}}],{},"animations":[{{"name":"go",
        "channels":[{{"sampler":0,"target":{{"node":0,"path":"{path}"}}}}],
        "samplers":[{{"input":{times},"output":{values},"interpolation":"{interpolation}"}}]}}]"#,
        mesh("")
    );
    (parts, rest)
}

#[test]
fn the_only_animation_shows_its_first_frame_and_any_time_can_be_asked_for() {
    let (parts, rest) =
        animated("translation", "VEC3", "LINEAR", &[1.0, 3.0], &[5.0, 0.0, 0.0, 7.0, 4.0, 0.0]);
    let first = parts.load(&rest);
    assert_bounds(&first, [5.0, 0.0, 0.0], [6.0, 1.0, 0.0]);
    assert_eq!((first.animation.as_deref(), first.animations.len()), (Some("go"), 1));
    let at = |choice| posed("linear", &parts, &rest, choice);
    assert_bounds(&at(pose(None, Some(2.0))).unwrap(), [6.0, 2.0, 0.0], [7.0, 3.0, 0.0]);
    assert_bounds(&at(pose(Some("go"), Some(100.0))).unwrap(), [7.0, 4.0, 0.0], [8.0, 5.0, 0.0]);
    assert_bounds(&at(pose(Some("none"), None)).unwrap(), [0.0, 0.0, 2.0], [1.0, 1.0, 2.0]);
    assert!(at(pose(Some("stop"), None)).unwrap_err().contains("none is called \"stop\": there is go"));
    let still = rest[..rest.find(r#","animations""#).unwrap()].to_owned();
    let message = posed("still", &parts, &still, pose(None, Some(1.0))).unwrap_err();
    assert!(message.contains("animations: there is none to be shown at 1 seconds"), "{message}");
}

#[test]
fn several_animations_are_clips_of_which_none_is_shown_unless_one_is_chosen() {
    let (parts, rest) = animated("translation", "VEC3", "LINEAR", &[0.0], &[5.0, 0.0, 0.0]);
    let twice = format!("{},{{\"name\":\"other\"}}]", rest.strip_suffix(']').unwrap());
    assert_bounds(&parts.load(&twice), [0.0, 0.0, 2.0], [1.0, 1.0, 2.0]);
    for choice in [pose(Some("go"), None), pose(Some("0"), None), pose(None, Some(0.0))] {
        let scene = posed("clips", &parts, &twice, choice).unwrap();
        assert_bounds(&scene, [5.0, 0.0, 0.0], [6.0, 1.0, 0.0]);
        assert_eq!(scene.animations, ["go", "other"]);
    }
}

#[test]
fn steps_splines_rotations_and_scales_follow_their_keys() {
    let at = |name: &str, (parts, rest): (Parts, String), time| {
        bounds(&posed(name, &parts, &rest, pose(None, Some(time))).unwrap())
    };
    let keys = [1.0, 0.0, 0.0, 2.0, 0.0, 0.0];
    let step = || animated("translation", "VEC3", "STEP", &[0.0, 1.0], &keys);
    assert_eq!(at("step", step(), 0.99)[0][0], 1.0);
    assert_eq!(at("step", step(), 1.0)[0][0], 2.0);
    // Tangents of zero: an ease from 1 to 2, half way at half time and 5/32 of it at a quarter.
    let [o, a, b] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    let spline = || animated("translation", "VEC3", "CUBICSPLINE", &[0.0, 1.0], &[o, a, o, o, b, o].concat());
    assert!((at("spline", spline(), 0.5)[0][0] - 1.5).abs() < 1e-6);
    assert!((at("spline", spline(), 0.25)[0][0] - 1.0 - 5.0 / 32.0).abs() < 1e-6);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    // From none to a quarter about z, half way an eighth; the end is written with the other sign.
    let turn =
        || animated("rotation", "VEC4", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -half, -half]);
    let eighth = at("turn", turn(), 0.5);
    assert!((eighth[1][1] - 2.0_f64.sqrt()).abs() < 1e-6 && eighth[0][2] == 2.0, "{eighth:?}");
    let grow = || animated("scale", "VEC3", "LINEAR", &[0.0, 1.0], &[1.0, 1.0, 1.0, 3.0, 1.0, 1.0]);
    assert_eq!(at("grow", grow(), 0.5)[1], [2.0, 1.0, 2.0]);
}

#[test]
fn pointers_move_nodes_too_and_others_are_told() {
    let (parts, rest) = animated("translation", "VEC3", "LINEAR", &[0.0], &[5.0, 0.0, 0.0]);
    let pointer = |to: &str| {
        let target =
            format!(r#"{{"path":"pointer","extensions":{{"KHR_animation_pointer":{{"pointer":"{to}"}}}}}}"#);
        rest.replace(r#"{"node":0,"path":"translation"}"#, &target)
    };
    assert_bounds(&parts.load(&pointer("/nodes/0/translation")), [5.0, 0.0, 0.0], [6.0, 1.0, 0.0]);
    let other = parts.load(&pointer("/materials/0/emissiveFactor"));
    assert_eq!(other.warnings[0].kind, WarningKind::Channel);
    assert_bounds(&other, [0.0, 0.0, 2.0], [1.0, 1.0, 2.0]);
    let nowhere = rest.replace(r#"{"node":0,"path":"translation"}"#, r#"{"path":"translation"}"#);
    assert!(parts.load(&nowhere).warnings.is_empty());
    let message = parts.refused(&rest.replace(r#""node":0,"path""#, r#""node":8,"path""#));
    assert!(message.contains("nodes[8]: index 8 is out of range"), "{message}");
    let message = parts.refused(&rest.replace("LINEAR", "BEZIER"));
    assert!(message.contains("interpolation \"BEZIER\" is not known"), "{message}");
}

#[test]
fn invisible_nodes_hide_what_is_below_them() {
    let parts = square();
    let nodes = |first: &str, second: &str| {
        let visible =
            |value: &str| format!(r#""extensions":{{"KHR_node_visibility":{{"visible":{value}}}}}"#);
        format!(
            r#""scenes":[{{"nodes":[0,2]}}],"nodes":[{{"children":[1],{}}},{{"mesh":0,{}}},{{"mesh":0,"translation":[5,0,0]}}],{}"#,
            visible(first),
            visible(second),
            mesh("")
        )
    };
    assert_bounds(&parts.load(&nodes("true", "true")), [0.0; 3], [6.0, 1.0, 0.0]);
    for (first, second) in [("false", "true"), ("true", "false")] {
        assert_bounds(&parts.load(&nodes(first, second)), [5.0, 0.0, 0.0], [6.0, 1.0, 0.0]);
    }
    let all = nodes("false", "true").replace(r#"[{"nodes":[0,2]}]"#, r#"[{"nodes":[0]}]"#);
    assert!(parts.refused(&all).contains("the file holds only hidden meshes"));
}

#[test]
fn far_from_the_origin_nothing_is_rounded() {
    let parts = square();
    let at = |translation: &str, scale: &str| {
        parts.load(&format!(
            r#""scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"translation":{translation},"scale":{scale}}}],
            "cameras":[],{}"#,
            mesh("")
        ))
    };
    let near = at("[0.3,0.1,0]", "[1,1,1]");
    for (far, distance) in [("[1000000.3,0.1,-1000000]", 1e6), ("[100000000.3,0.1,-100000000]", 1e8)] {
        let scene = at(far, "[1,1,1]");
        assert_ne!(scene.origin, [0.0; 3]);
        assert_bounds(&scene, [distance + 0.3, 0.1, -distance], [distance + 1.3, 1.1, -distance]);
        for (a, b) in near.vertices.iter().zip(&scene.vertices).take(4) {
            for k in 0..3 {
                let world = f64::from(b.position[k]) + scene.origin[k] - [distance, 0.0, -distance][k];
                assert!((f64::from(a.position[k]) - world).abs() < 1e-6, "{a:?} {b:?}");
            }
        }
    }
    assert_eq!(near.origin, [0.0; 3]);
    // A scene of a tenth of a millimetre at a hundred metres.
    let tiny = at("[100,0,0]", "[1e-4,1e-4,1]");
    assert_bounds(&tiny, [100.0, 0.0, 0.0], [100.0001, 0.0001, 0.0]);
    let width = tiny.bounds[1][0] - tiny.bounds[0][0];
    assert!((width / 1e-4 - 1.0).abs() < 1e-6, "{width}");
}

#[test]
fn a_centre_of_cesium_moves_all() {
    let parts = square();
    let scene = parts.load(&format!(
        r#""extensionsRequired":["CESIUM_RTC"],"extensions":{{"CESIUM_RTC":{{"center":[6378137,0,12]}}}},
        "scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],{}"#,
        mesh("")
    ));
    assert_bounds(&scene, [6378137.0, 0.0, 12.0], [6378138.0, 1.0, 12.0]);
}

#[test]
fn lights_of_the_file_are_views_and_its_cameras_cameras() {
    let parts = square();
    let scene = parts.load(&format!(
        r#""extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"directional","name":"low sun"}},{{"type":"spot"}},{{"type":"point","name":"bulb"}}]}}}},
        "scenes":[{{"nodes":[0,1,2,3,4,5,6]}}],"nodes":[{{"mesh":0}},
        {{"name":"evening","rotation":[-0.5,0,0,0.8660254],"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}},
        {{"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}},
        {{"name":"torch","translation":[0,0,5],"extensions":{{"KHR_lights_punctual":{{"light":1}}}}}},
        {{"extensions":{{"KHR_lights_punctual":{{"light":2}}}}}},
        {{"name":"tilted","camera":0,"translation":[0,0,5],"rotation":[0,0,0.70710678,0.70710678]}},
        {{"camera":0,"translation":[0,0,9]}}],
        "cameras":[{{"name":"wide","type":"perspective","perspective":{{"yfov":0.9,"znear":0.1}}}}],{}"#,
        mesh("")
    ));
    let names: Vec<&str> = scene.views.iter().map(|view| view.name.as_str()).collect();
    assert_eq!(names, ["default", "evening", "low sun", "torch", "wide", "lamp"]);
    let evening = scene.views[1].direction;
    assert!((evening[1] + 0.866_025_4).abs() < 1e-6 && (evening[2] + 0.5).abs() < 1e-6, "{evening:?}");
    assert_eq!(scene.views[2].direction, [0.0, 0.0, -1.0]);
    let torch = scene.views[3].light.front().unwrap();
    assert!((torch[2] + 1.0).abs() < 1e-9, "{torch:?}");
    assert_eq!(scene.warnings.len(), 1);
    assert!(scene.warnings[0].message.contains("light \"bulb\" is not used"));
    let cameras: Vec<&str> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(cameras, ["tilted", "wide"]);
    assert_eq!(scene.camera, scene.cameras[0].camera);
    assert!((scene.camera.up[0] + 1.0).abs() < 1e-6, "{:?}", scene.camera.up);
}

//! Mesh files as other programs write them: skins, strips, what is not of triangles, long lines, colours.

use crate::common::glb_of;
use glam::{DMat4, DVec3};
use windswept_scene::Triangles;

/// The places of the corners of a `.glb` file of one primitive with these keys, of nodes and skins, over four points in
/// the plane z = 0, indices 0 to 3, and what comes behind both.
fn corners(keys: &str, nodes: &str, more: &[u8], accessors: &str) -> Vec<DVec3> {
    let points = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let mut numbers: Vec<u8> = points.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    numbers.extend((0..4_u32).flat_map(u32::to_le_bytes));
    numbers.extend(more);
    let json = format!(
        r#"{{"extensionsUsed":["KHR_texture_basisu"],"extensionsRequired":["KHR_texture_basisu","KHR_materials_unlit"],
        "scene":1,"scenes":[{{"nodes":[0,0]}},{{"nodes":[1]}}],"nodes":[{{"mesh":0,"translation":[9,9,9]}},{nodes}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":1}},{{"attributes":{{"POSITION":0}},"mode":0}},
        {{"indices":1,{keys}}}]}}],"accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":4}},
        {{"bufferView":0,"byteOffset":48,"componentType":5125,"type":"SCALAR","count":4}}{accessors}],
        "bufferViews":[{{"buffer":0}}]}}"#
    );
    let mesh = Triangles::read("glb", &glb_of(&json, &numbers)).unwrap();
    mesh.corners.as_flattened().iter().map(|&i| mesh.points[i as usize]).collect()
}

/// Strips and fans are triangles of one side; points, lines and other scenes are left out; looks are no reason to
/// refuse.
#[test]
fn strips_and_fans_are_read() {
    let [a, b, c, d] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y];
    let node = r#"{"mesh":0,"translation":[0,0,1]}"#;
    for (mode, expected) in [(5, [a, b, c, c, b, d]), (6, [a, b, c, a, c, d])] {
        let found = corners(&format!(r#""attributes":{{"POSITION":0}},"mode":{mode}"#), node, &[], "");
        assert_eq!(found, expected.map(|x| x + DVec3::Z), "mode {mode}");
    }
}

/// The joints of a skin carry the points, by their weights, and the mesh's own node does not.
#[test]
fn joints_carry_a_skin() {
    // Joint 2 is at (1, 0, 0) now and was at (0, 0, 3) when it was bound; joint 3 is below it, turned, and was at the
    // origin.
    let turn = std::f64::consts::FRAC_1_SQRT_2;
    let nodes = format!(
        r#"{{"mesh":0,"skin":0,"translation":[5,0,0],"children":[2]}},
        {{"translation":[-4,0,0],"children":[3]}},{{"rotation":[0,0,{turn},{turn}]}}],"skins":[{{"joints":[2,3],"inverseBindMatrices":4}}"#
    );
    let bound = [DMat4::from_translation(DVec3::new(0.0, 0.0, -3.0)), DMat4::IDENTITY];
    let weights: [[u8; 4]; 4] = [[255, 0, 0, 0], [0, 255, 0, 0], [100, 100, 0, 0], [0, 51, 0, 0]];
    let joints = [[0_u8, 1, 0, 0]; 4];
    let mut more: Vec<u8> =
        bound.iter().flat_map(|m| m.to_cols_array()).flat_map(|x| (x as f32).to_le_bytes()).collect();
    more.extend(joints.as_flattened());
    more.extend(weights.as_flattened());
    let accessors = r#",{"bufferView":0,"byteOffset":192,"componentType":5121,"type":"VEC4","count":4},
        {"bufferView":0,"byteOffset":208,"componentType":5121,"type":"VEC4","count":4},
        {"bufferView":0,"byteOffset":64,"componentType":5126,"type":"MAT4","count":2}"#;
    let found = corners(r#""attributes":{"POSITION":0,"JOINTS_0":2,"WEIGHTS_0":3},"mode":5"#, &nodes, &more, accessors);
    let first = |x: DVec3| x + DVec3::new(1.0, 0.0, -3.0);
    let second = |x: DVec3| DVec3::new(1.0 - x.y, x.x, x.z);
    let [a, b, c, d] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y];
    let [a, b, c, d] = [first(a), second(b), 0.5 * (first(c) + second(c)), second(d)];
    for (x, expected) in found.iter().zip([a, b, c, c, b, d]) {
        assert!(x.distance(expected) < 1e-6, "{x} {expected}");
    }
}

/// Lines may go on, end as on any system, and have colours behind their points; a fault names its own line.
#[test]
fn lines_of_wavefront_files_are_of_any_program() {
    let text = "v 0 0 0 1 0 0\nv 1 0 0 0.5 0.5 0.5 1\nv 0 1 0\nv 0 0 \\\n1\nf 1 2 \\\n3\nf 1 4 2\n";
    let plain = Triangles::read("obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\n").unwrap();
    for text in [text.to_owned(), text.replace('\n', "\r\n"), text.replace('\n', "\r")] {
        let mesh = Triangles::read("obj", text.as_bytes()).unwrap();
        assert_eq!((&mesh.points, &mesh.corners), (&plain.points, &plain.corners), "{text:?}");
        let error = Triangles::read("obj", format!("{text}f 1 2 9\n").as_bytes()).unwrap_err();
        assert!(error.message().starts_with("line 9: "), "{error}");
    }
    // A mark of the encoding and a comment that ends in a backslash take no line away.
    for head in ["\u{feff}", "# from C:\\tmp\\\n", "\u{feff}# C:\\\n"] {
        let mesh = Triangles::read("obj", format!("{head}{text}").as_bytes()).unwrap();
        assert_eq!(mesh.points, plain.points, "{head:?}");
    }
    for (text, line) in [("f\\\n1 2 3\nf 1 2 9\n", 3), ("\\\nf 1 2 \\\n3\nf 1 2 9\n", 4)] {
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{text}");
        let error = Triangles::read("obj", text.as_bytes()).unwrap_err();
        assert!(error.message().starts_with(&format!("line {}: ", line + 3)), "{text:?}: {error}");
    }
}

/// A skin whose points lack weights, and a default scene without a mesh, are faults; a file without scenes shows all.
#[test]
fn faults_of_skins_and_scenes_are_named() {
    let file = |scenes: &str, skin: &str, attributes: &str| {
        let json = format!(
            r#"{{{scenes}"nodes":[{{}},{{"mesh":0{skin}}}],"skins":[{{"joints":[0]}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0{attributes}}}}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}},
            {{"bufferView":0,"componentType":5121,"type":"VEC4","count":3}},
            {{"bufferView":0,"componentType":5121,"type":"VEC4","count":2}}],"bufferViews":[{{"buffer":0}}]}}"#
        );
        let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_le_bytes);
        Triangles::read("glb", &glb_of(&json, corners.as_flattened())).map_err(|error| error.message().to_owned())
    };
    let shown = r#""scene":0,"scenes":[{"nodes":[0,1]}],"#;
    let weights = "mesh 0, primitive 0: expected four joints and four weights a point";
    for (scenes, skin, attributes, expected) in [
        ("", "", "", None),
        (shown, "", "", None),
        (
            r#""scenes":[{"nodes":[0]},{"nodes":[1]}],"#,
            "",
            "",
            Some("the file's default scene shows no mesh: expected one in it"),
        ),
        (r#""scene":7,"scenes":[{"nodes":[1]}],"#, "", "", Some("found scene 7: expected less than 1")),
        (shown, r#","skin":0"#, "", Some(weights)),
        (shown, r#","skin":0"#, r#","JOINTS_0":1,"WEIGHTS_0":2"#, Some(weights)),
        (shown, r#","skin":1"#, "", Some("found skin 1: expected less than 1")),
    ] {
        let found = file(scenes, skin, attributes);
        assert_eq!(found.as_ref().err().map(String::as_str), expected, "{scenes} {skin} {attributes}");
        assert!(found.is_err() || found.unwrap().corners.len() == 1);
    }
}

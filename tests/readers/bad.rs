//! Files that are not what they should be: each is refused with its name, the line, what was expected and
//! what was found. And what is odd but sound, which is read.

use std::fs;

use crate::common::place;
use perion::{Error, Points};

/// Reads a file of this name and text.
fn read(name: &str, text: impl AsRef<[u8]>) -> Result<Points, Error> {
    let thread = std::thread::current();
    let test = thread.name().unwrap().replace("::", "_");
    let path = place(&format!("readers/{test}")).join(name);
    fs::write(&path, text).unwrap();
    Points::read(path)
}

fn refused(name: &str, text: impl AsRef<[u8]>) -> String {
    match read(name, text) {
        Err(Error::Format(text) | Error::Unsupported(text)) => text,
        other => panic!("{name}: {other:?}"),
    }
}

/// Each text is refused at its line with these words.
fn hold(name: &str, cases: &[(&str, usize, &str)]) {
    for &(text, line, words) in cases {
        let said = refused(name, text);
        let place = match line {
            0 => format!("{name}': "),
            line => format!("{name}', line {line}: "),
        };
        assert!(said.contains(&place) && said.contains(words), "{text:?} is refused with: {said}");
    }
}

#[test]
fn text_that_is_no_cloud() {
    hold(
        "cloud.txt",
        &[
            ("", 0, "expected points, found none"),
            ("# nothing\n\n! here\n", 0, "expected points, found none"),
            ("x y z volume\n", 0, "expected points, found none"),
            ("x y z volume\nx y z volume\n", 2, "expected a number as x, found 'x'"),
            ("x y z\n0 0 1\n", 1, "expected columns named x, y, z and volume"),
            ("x,y,z,radius\n0,0,0,1\n", 1, "found 'x,y,z,radius'"),
            ("x,x,y,volume\n0,0,0,1\n", 1, "each once"),
            ("1 2\n", 1, "found 2 columns: '1 2'"),
            ("1 2 3 4 5 6\n", 1, "found 6 columns"),
            ("0 0 0 1\n1 0 0\n", 2, "expected 4 columns as in the lines before, found 3: '1 0 0'"),
            ("0 0 0 1\n1,,0 1\n", 2, "expected something between two commas, found '1,,0 1'"),
            ("0 0 0 1\n0 zero 0 1\n", 2, "expected a number as y, found 'zero'"),
            ("0 0 0 1\n\n0 0 nan 1\n", 3, "expected a number as z, found 'nan'"),
            ("nan nan nan nan\n", 1, "expected a number as x, found 'nan'"),
            ("0 0 0 1\n0 0 1e200 1\n", 2, "expected a number as z, found '1e200'"),
            ("0 0 0 0\n", 1, "expected a positive number as volume, found '0'"),
            ("0 0 0 -1\n", 1, "expected a positive number as volume, found '-1'"),
            ("0 0 0 inf\n", 1, "expected a positive number as volume, found 'inf'"),
            ("0 0 0 1.5 1\n", 1, "expected a whole number as block, found '1.5'"),
            ("0 0 -1\n", 1, "expected a positive number as area, found '-1'"),
            ("0 0 0 1\n1 0 0 1\n0.0 0 -0 1\n", 3, "found the one of line 1"),
            ("0 0 0 \u{e9}\n", 1, "found '\u{e9}'"),
        ],
    );
    let said = refused("cloud.txt", [b"0 0 0 1\n".as_slice(), &[0xff; 5000]].concat());
    assert!(said.len() < 300, "{said}");
}

#[test]
fn columns_may_be_named_in_any_order_with_units_and_beside_others() {
    for text in [
        "id,\"x\",\"y\",\"z\",\"Volume\"\n7,1,2,3,0.5\n8,2,2,3,0.25\n",
        "volume[mm3] x[mm] y(mm) z\n0.5 1 2 3\n0.25 2 2 3\n",
        "# made by hand\nPoints:0,Points:1,Points:2,radius,volume,\n1,2,3,9,.5,\n2,2,3,9,.25,\n",
        "block volume x y z\n4 0.5 1 2 3\n4 0.25 2 2 3\n",
    ] {
        let points = read("named.csv", text).unwrap();
        assert_eq!(points.coordinates(), [1.0, 2.0, 3.0, 2.0, 2.0, 3.0], "{text}");
        assert_eq!(points.volumes(), [0.5, 0.25], "{text}");
        assert_eq!(points.set_names().len(), usize::from(text.starts_with("block")), "{text}");
    }
    let plane = read("plane.txt", "y x area\n2 1 0.5\n").unwrap();
    assert_eq!((plane.dimension(), plane.coordinates()), (2, &[1.0, 2.0][..]));
}

#[test]
fn files_of_other_kinds_are_not_taken_for_text() {
    let said = refused("mesh.vtk", "# vtk DataFile Version 3.0\n");
    assert!(said.contains("files that end in .vtk are not read; known are .inp"), "{said}");
}

/// What a few bytes say must not take the reader long, or fill the memory.
#[test]
fn hostile_files_are_dealt_with_soon() {
    let start = std::time::Instant::now();
    let many = |text: &str, times: usize| text.repeat(times);
    let tetrahedra = |count: usize| {
        let mut text = String::from("*NODE\n");
        for node in 1..count + 4 {
            let t = node as f64;
            text += &format!("{node},{},{},{}\n", t, (0.7 * t).sin(), (1.3 * t).cos());
        }
        text += "*ELEMENT,TYPE=C3D4\n";
        for cell in 1..=count {
            text += &format!("{cell},{cell},{},{},{}\n", cell + 1, cell + 2, cell + 3);
        }
        text
    };
    let mesh = tetrahedra(4000);
    // Sets that name sets, lines that name the same again, and nodes likewise.
    let a = format!(
        "*ELSET,ELSET=A\n{}",
        (1..4000).step_by(2).map(|k| format!("{k}\n")).collect::<String>()
    );
    let inp = |more: &str| read("hostile.inp", format!("{mesh}{more}"));
    let twice = inp(&format!("{a}*ELSET,ELSET=B\n{}", many("A\n", 20_000))).unwrap();
    assert_eq!(twice.set("B").unwrap(), twice.set("A").unwrap());
    let sets: String = (0..3000).map(|k| format!("*ELSET,ELSET=B{k}\nA\n")).collect();
    let said = inp(&format!("{a}{sets}")).unwrap_err().to_string();
    assert!(said.contains("stand in more than 1000 sets each"), "{said}");
    let again = inp(&format!("*ELSET,ELSET=A,GENERATE\n{}", many("1,4000\n", 40_000))).unwrap();
    assert_eq!(again.set_size("A").unwrap(), 4000);
    let steps: String = (1..20_000).map(|k| format!("1,4000,{}\n", 1 + k % 7)).collect();
    assert!(inp(&format!("*ELSET,ELSET=A,GENERATE\n{steps}")).is_ok());
    let nodes = inp(&format!("*NSET,NSET=A\n{}", many("1\n", 50_000))).unwrap();
    assert_eq!(nodes.set("A").unwrap(), [0]);
    let circle = inp("*ELSET,ELSET=A\n1\n*ELSET,ELSET=B\nA\n2\n*ELSET,ELSET=A\nB\n").unwrap();
    assert_eq!(circle.set("A").unwrap(), circle.set("B").unwrap());
    // As many sets of one name as there are cells.
    let names: String = (1..=20_000).map(|k| format!("2 {k} \"a\"\n")).collect();
    let cells: String =
        (1..=20_000).map(|k| format!("{k} 2 1 {k} {k} {} {}\n", k + 1, k + 2)).collect();
    let corners: String = (1..20_003).map(|k| format!("{k} {} {} 0\n", k / 2, k % 2)).collect();
    let text = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n20000\n{names}$EndPhysicalNames\n\
         $Nodes\n20002\n{corners}$EndNodes\n$Elements\n20000\n{cells}$EndElements\n"
    );
    assert_eq!(read("hostile.msh", text).unwrap().set_names().len(), 20_000);
    // The same bytes for many pieces.
    let piece = "<Piece NumberOfPoints=\"60000\" NumberOfCells=\"0\"><Points><DataArray type=\"Int8\" \
                 NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points></Piece>";
    let mut vtu =
        format!("<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>{}", many(piece, 6000))
            .into_bytes();
    vtu.extend_from_slice(b"</UnstructuredGrid><AppendedData encoding=\"raw\">_");
    vtu.extend_from_slice(&180_000_u32.to_le_bytes());
    vtu.extend(std::iter::repeat_n(1_u8, 180_000));
    assert!(refused("hostile.vtu", vtu).contains("the same bytes used again"));
    let long = format!("<VTKFile type=\"UnstructuredGrid\"></{}>", many("x", 3_000_000));
    assert!(refused("hostile.vtu", long).len() < 400);
    assert!(
        refused(
            "hostile.msh",
            format!("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n${}", many("x", 1_000_000))
        )
        .len()
            < 400
    );
    // A second is usual; machines differ.
    assert!(start.elapsed().as_secs() < 30, "{:?}", start.elapsed());
}

#[test]
fn abaqus_files_that_are_no_mesh() {
    const NODES: &str = "*Node\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n";
    let with = |rest: &str| format!("{NODES}{rest}");
    let cases = [
        (String::new(), 0, "expected solid or plane elements, found none"),
        (with(""), 0, "expected solid or plane elements, found none"),
        ("*Node\n1,0,x,0\n".into(), 2, "expected a coordinate of node 1, found 'x'"),
        ("*Node\n0,0,0,0\n".into(), 2, "whole and positive, found '0'"),
        ("*Node\n1.5,0,0,0\n".into(), 2, "whole and positive, found '1.5'"),
        ("*Node\n1,0,0,1e999\n".into(), 2, "found '1e999'"),
        (
            with("*Element, type=C3D4\n1,1,2,3,4\n*Node\n2,5,5,5\n"),
            9,
            "expected node 2 once, found it again after line 3",
        ),
        (with("*Element\n1,1,2,3,4\n"), 6, "expected TYPE= of *ELEMENT, found none"),
        (with("*Element, type=C3D15\n"), 6, "elements of type 'C3D15' are not read"),
        (with("*Element, type=SC8R\n"), 6, "elements of type 'SC8R' are not read"),
        (with("*Element, type=CAX4\n"), 6, "elements of type 'CAX4' are not read"),
        (
            with("*Element, type=C3D4\n1,1,2,3,9\n"),
            7,
            "expected a node that the file has, found node 9 in element 1",
        ),
        (
            with("*Element, type=C3D4\n1,1,2,3\n"),
            8,
            "expected 1 more nodes of the element before, found 'the end of the file'",
        ),
        (with("*Element, type=C3D4\n1,1,2,3\n*Nset, nset=a\n"), 8, "found '*Nset, nset=a'"),
        (
            with("*Element, type=C3D4R\n1,1,2,3,4,5\n"),
            7,
            "expected 4 nodes of an element of type 'C3D4R', found more: '5'",
        ),
        (with("*Element, type=C3D4\n1,1,2,,4\n"), 7, "whole and positive, found ''"),
        (
            with("*Element, type=C3D4\n1,1,2,3,4\n1,1,2,4,3\n"),
            8,
            "expected element 1 once, found it again after line 7",
        ),
        (
            with("*Element, type=C3D4\n1,1,2,3,4\n2,1,2,4,3\n"),
            8,
            "expected nodes of its own for element 2, found those of element 1",
        ),
        (with("*Element, type=C3D4\n7,1,2,3,3\n"), 7, "found element 7 flat, folded"),
        (with("*Element, type=S3\n7,1,2,4\n"), 7, "found element 7 at z = 1; shells"),
        (
            with("*Element, type=C3D4\n1,1,2,3,4\n*Elset, elset=a\n1,2\n"),
            9,
            "expected elements that the file has in set 'a', found 2",
        ),
        (
            with("*Element, type=C3D4\n1,1,2,3,4\n*Nset, nset=a\n9\n"),
            9,
            "expected nodes that the file has in set 'a', found 9",
        ),
        (
            with("*Elset, elset=a\nb\n"),
            7,
            "expected numbers or the name of a set before this line, found 'b'",
        ),
        (with("*Elset\n1\n"), 6, "expected ELSET= of *ELSET, found none"),
        (with("*Nset, nset=\n1\n"), 6, "expected the name of a set, found none"),
        (with("*Nset, nset=a, generate\n1\n"), 7, "expected the last number"),
        (with("*Nset, nset=a, generate\n1,4,0\n"), 7, "expected a step"),
        (
            with("*Include, input=more.inp\n"),
            6,
            "'*Include, input=more.inp' is not read; put the included file's lines in its place",
        ),
        (
            "*Assembly, name=a\n*Instance, name=b, part=c\n".into(),
            2,
            "is not read; write a flat input file",
        ),
        (with("*Nset, nset=a, instance=b-1\n1\n"), 6, "INSTANCE= of *NSET is not read"),
        ("*Node, input=nodes.txt\n".into(), 1, "INPUT= of *NODE is not read"),
        ("*Node, system=C\n1,1,0,0\n".into(), 1, "rectangular system"),
        ("*System\n1,2,3\n".into(), 1, "'*System' is not read"),
        (with("*Ngen\n1,4\n"), 6, "'*Ngen' is not read; write out the nodes"),
        (with("*Elgen\n1,4\n"), 6, "'*Elgen' is not read; write out the elements"),
        (
            with("*Elem, type=C3D4\n"),
            6,
            "expected keywords in full, found '*Elem, type=C3D4': *ELEMENT?",
        ),
        (
            with("*Incl, input=a\n"),
            6,
            "expected keywords in full, found '*Incl, input=a': *INCLUDE?",
        ),
        (with("*Elset, elset=a, gen\n1,2\n"), 6, "expected parameters of *ELSET among"),
        (
            with("*Element, type=C3D4,\n1,1,2,3,4\n"),
            6,
            "expected parameters of *ELEMENT among TYPE, ELSET, INPUT, found '1'",
        ),
        (with("*Element, type=C3D4, offset=5\n"), 6, "found 'offset=5'"),
        (
            with("*Nset, nset=a, generate\n3,1\n"),
            7,
            "expected a first number, a last one not below it",
        ),
        (with("*Nset, nset=a, generate\n1,3,1,7\n"), 7, "found '1,3,1,7'"),
    ];
    let cases: Vec<(&str, usize, &str)> =
        cases.iter().map(|(text, line, words)| (text.as_str(), *line, *words)).collect();
    hold("mesh.inp", &cases);
}

#[test]
fn abaqus_files_that_are_odd_but_sound() {
    let mesh = read(
        "odd.INP",
        "\u{feff}** comment\r\n*HEADING\r\n 1, 2, 3\r\n*node, nset=Every\r\n 1, , 0.0\r\n2,1.D0,0,0\r\n3,0,1,0\r\n\
         4,0,0,1.\r\n5,1,1,1,0,0,1\r\n*ELEMENT,\r\n TYPE = c3d4r,\r\n ELSET = \"Two Words\"\r\n10,1,2,\r\n3,4\r\n\
         **\r\n20,2,3,4,5\r\n*Material, name=a\r\n*Elastic\r\n1,0.3\r\n*NSET, NSET=tip, GENERATE\r\n5,9,2\r\n\
         *Nset, nset=tip\r\n5\r\n*ELSET, ELSET=second\r\n20,\r\n*Elset, elset=both\r\nSECOND,\"Two Words\"\r\n\
         *Elset, elset=SECOND\r\n20\r\n*Nset, nset=both\r\n5\r\n*nset, nset=lonely\r\n",
    )
    .unwrap();
    assert_eq!((mesh.count(), mesh.dimension()), (2, 3));
    let sets: Vec<(&str, Vec<usize>)> =
        mesh.set_names().map(|name| (name, mesh.set(name).unwrap())).collect();
    assert_eq!(
        sets,
        [
            // The nodes called "both" belong to other points than the elements of that name.
            ("Every", vec![0, 1]),
            ("Two Words", vec![0, 1]),
            ("both", vec![0, 1]),
            ("both_2", vec![1]),
            ("second", vec![1]),
            ("tip", vec![1]),
        ]
    );
}

#[test]
fn abaqus_names_in_quotes_and_elements_without_volume() {
    let mesh = read(
        "names.inp",
        "*Node\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,2,0,0\n6,2,1,1\n*Element, type=C3D4, elset=Body\n\
         1,1,2,3,4\n2,2,5,3,6\n*Element, type=MASS, elset=weights\n3,1\n*Element, type=B31\n4,1,2,5\n\
         *Elset, elset=\"bolt, left\"\n1\n*Elset, elset=\"bolt, right\"\n2\n*Elset, elset=BODY\n4\n\
         *Nset, nset=end, elset=\"bolt, right\"\n*Nset, nset=far\n6\n",
    )
    .unwrap();
    let sets: Vec<(&str, Vec<usize>)> =
        mesh.set_names().map(|name| (name, mesh.set(name).unwrap())).collect();
    assert_eq!(
        sets,
        [
            ("Body", vec![0, 1]),
            ("bolt, left", vec![0]),
            ("bolt, right", vec![1]),
            // All nodes of the second element, of which the first has two.
            ("end", vec![0, 1]),
            ("far", vec![1]),
        ]
    );
}

#[test]
fn gmsh_files_that_are_no_mesh() {
    const HEAD: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
    const HEAD2: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
    const NODES: &str = "$Nodes\n1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n";
    const NODES2: &str = "$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n";
    let four = |rest: &str| format!("{HEAD}{rest}");
    let meshed = |rest: &str| format!("{HEAD}{NODES}{rest}");
    let two = |rest: &str| format!("{HEAD2}{rest}");
    let cases = [
        (String::new(), 1, "expected $MeshFormat at the beginning"),
        ("hello\n".into(), 1, "expected $ and a section, found 'hello'"),
        ("$Nodes\n".into(), 1, "expected $MeshFormat at the beginning"),
        (
            "$MeshFormat\n4 0 8\n".into(),
            2,
            "expected version 4.1 or 2.2, found '4 0 8'; save it as 4.1",
        ),
        ("$MeshFormat\n1.0 0 8\n".into(), 2, "expected version 4.1 or 2.2"),
        ("$MeshFormat\n4.1 1 4\n".into(), 2, "expected 0 8 or 1 8, found '4.1 1 4'"),
        (
            "$MeshFormat\n4.1 0 8\n$Nodes\n".into(),
            3,
            "expected the end of section 'MeshFormat', found '$Nodes'",
        ),
        (four(""), 0, "expected solid or plane elements, found none"),
        (four("$Comments\nno end\n"), 4, "expected the end of section 'Comments'"),
        (four("$PartitionedEntities\n"), 4, "partitioned meshes are not read"),
        (
            four("$PhysicalNames\n1\n2 x \"a\"\n"),
            6,
            "expected a dimension, a number and a name in quotes",
        ),
        (four("$Nodes\nx\n"), 5, "expected a number of blocks, whole and not negative, found 'x'"),
        (four("$Nodes\n-1 0 0 0\n"), 5, "found '-1'"),
        (
            four("$Nodes\n99999999 3 1 3\n"),
            5,
            "expected a number of blocks that the file has room for, found 99999999",
        ),
        (
            four("$Nodes\n1 999999999999 1 3\n"),
            5,
            "expected a number of nodes that the file has room for",
        ),
        (
            four("$Nodes\n1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 x\n"),
            12,
            "expected a coordinate, found 'x'",
        ),
        (
            four("$Nodes\n1 4 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n"),
            12,
            "expected 4 nodes, found 3 in all blocks",
        ),
        (
            four("$Nodes\n1 1 1 1\n7 1 0 1\n1\n0 0 0\n"),
            6,
            "expected a dimension of 0 to 3, found 7",
        ),
        (
            meshed("$Elements\n1 1 1 1\n2 1 99 1\n1 1 2 3\n$EndElements\n"),
            16,
            "elements of type 99 are not read",
        ),
        (
            meshed("$Elements\n1 1 1 1\n2 1 2 1\n1 1 2 9\n$EndElements\n"),
            17,
            "found node 9 in element 1",
        ),
        (
            meshed("$Elements\n1 1 1 1\n2 1 2 1\n1 1 2 2\n$EndElements\n"),
            17,
            "found element 1 flat",
        ),
        (
            meshed("$Elements\n1 1 1 1\n2 1 2 1\n1 1 2 3\n$End\n"),
            18,
            "expected the end of section 'Elements', found '$End'",
        ),
        (
            meshed("$Elements\n1 2 1 2\n2 1 2 2\n1 1 2 3\n2 2 3 1\n$EndElements\n"),
            18,
            "expected nodes of its own for element 2, found those of element 1",
        ),
        (two("$Nodes\n3 0\n"), 5, "expected the number of nodes on a line, found '3 0'"),
        (two("$Nodes\n999999999\n1 0 0 0\n"), 5, "that the file has room for, found 999999999"),
        (
            two(&format!("{NODES2}$Elements\n1\n1 2 2 0 1 1 2\n$EndElements\n")),
            13,
            "expected a node, whole and not negative, found '$EndElements'",
        ),
        (
            two(&format!("{NODES2}$Elements\n1\n1 2 9999 0 1 1 2 3\n$EndElements\n")),
            12,
            "expected a number of tags that the file has room for",
        ),
        (
            two(
                "$Nodes\n4\n1 0 0 0\n1 1 0 0\n2 1 1 0\n3 0 1 0\n$EndNodes\n$Elements\n1\n1 2 0 1 2 3\n$EndElements\n",
            ),
            7,
            "expected node 1 once, found it again after line 6",
        ),
    ];
    let cases: Vec<(&str, usize, &str)> =
        cases.iter().map(|(text, line, words)| (text.as_str(), *line, *words)).collect();
    hold("mesh.msh", &cases);
    // Written where the highest byte comes first.
    let said = refused("mesh.msh", b"$MeshFormat\n4.1 1 8\n\0\0\0\x01\n$EndMeshFormat\n");
    assert!(said.contains("of another byte order"), "{said}");
}

#[test]
fn vtk_files_that_are_no_cloud() {
    let piece = |rest: &str| {
        format!(
            "<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"2\" \
             NumberOfCells=\"0\">\n{rest}</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"
        )
    };
    let points = |attributes: &str, numbers: &str| {
        piece(&format!("<Points>\n<DataArray {attributes}>{numbers}</DataArray>\n</Points>\n"))
    };
    let reals = "type=\"Float64\" NumberOfComponents=\"3\"";
    let cells = |offsets: &str, types: &str, corners: &str| {
        let array = |name: &str, numbers: &str| {
            format!("<DataArray type=\"Int64\" Name=\"{name}\">{numbers}</DataArray>\n")
        };
        format!(
            "<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"4\" \
             NumberOfCells=\"1\">\n<Points>\n<DataArray {reals}>0 0 0 1 0 0 0 1 0 0 0 1</DataArray>\n\
             </Points>\n<Cells>\n{}{}{}</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n",
            array("offsets", offsets),
            array("types", types),
            array("connectivity", corners)
        )
    };
    let cases = [
        (String::new(), 1, "expected VTKFile, found the end of the file"),
        ("<a>\n".into(), 1, "expected VTKFile, found 'a'"),
        ("<VTKFile>\n".into(), 1, "expected an attribute 'type', found none"),
        (
            "<VTKFile type=\"PolyData\">\n".into(),
            1,
            "expected an UnstructuredGrid, found 'PolyData'",
        ),
        (
            "<VTKFile type=\"UnstructuredGrid\" compressor=\"vtkLZ4DataCompressor\">\n".into(),
            1,
            "packed by 'vtkLZ4DataCompressor' are not read",
        ),
        (
            "<VTKFile type=\"UnstructuredGrid\" header_type=\"UInt16\">\n".into(),
            1,
            "expected a header_type, found 'UInt16'",
        ),
        (
            "<VTKFile type=\"UnstructuredGrid\">\n</VTKFile>\n".into(),
            0,
            "expected an UnstructuredGrid, found none",
        ),
        (
            "<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n</Piece>\n".into(),
            3,
            "expected XML, found",
        ),
        (piece(""), 3, "expected an array of Points, found none"),
        (points(reals, "0 0 0"), 5, "expected 6 numbers, found 3"),
        (points(reals, "0 0 0 1 0 x"), 5, "expected a number, found 'x'"),
        (points("type=\"Float64\"", "0 0 0 1 0 0"), 5, "expected 3 components of Points, found 1"),
        (points(reals, "0 0 0 1 0 0"), 3, "an array 'volume' of PointData, found neither"),
        (points(&format!("{reals} format=\"binary\""), "AAAA"), 5, "found the end of the data"),
        (
            points(&format!("{reals} format=\"binary\""), "/////w=="),
            5,
            "array of Points: expected 48 bytes, found 4294967295",
        ),
        (
            points(&format!("{reals} format=\"appended\" offset=\"0\""), ""),
            5,
            "expected AppendedData, found none",
        ),
        (points(&format!("{reals} format=\"sparse\""), ""), 5, "expected a format, found 'sparse'"),
        (cells("5", "10", "0 1 2 3"), 8, "expected offsets from 0 to 4, found 5 of cell 0"),
        (cells("-1", "10", "0 1 2 3"), 8, "found -1 of cell 0"),
        (cells("3", "10", "0 1 2"), 8, "expected 4 points of cell 0 of type 10, found 3"),
        (cells("4", "10", "0 1 2 4"), 10, "expected points from 0 to 3, found 4 in cell 0"),
        (cells("4", "10", "0 1 2 2"), 0, "found element 0 flat"),
        (cells("4", "42", "0 1 2 3"), 3, "cells of type 42 are not read"),
        (cells("4 4", "10", "0 1 2 3"), 8, "expected 1 numbers, found 2"),
        (
            cells("4", "10", "0 1 2 3").replace("offsets", "ends"),
            3,
            "expected an array 'offsets' of Cells",
        ),
    ];
    let cases: Vec<(&str, usize, &str)> =
        cases.iter().map(|(text, line, words)| (text.as_str(), *line, *words)).collect();
    hold("cloud.vtu", &cases);
}

#[test]
fn vtk_files_that_are_odd_but_sound() {
    let text = "\u{feff}<?xml version='1.0'?>\n<!-- by hand -->\n<VTKFile type='UnstructuredGrid'>\n\
        <UnstructuredGrid><FieldData><DataArray type='Float64' Name='t'>1</DataArray></FieldData>\n\
        <Piece NumberOfPoints='5' NumberOfCells='3'><Points><DataArray type='Float64' NumberOfComponents='3'>\n\
        <!-- square --> 0 0 0 <![CDATA[1 0 0]]> 1 1 0 0 1 0 <InformationKey name='a'>7</InformationKey>\n\
        3 0 0</DataArray></Points>\n<Cells><DataArray type='Int32' Name='connectivity'>0 1 2 3 0 1 2 1 4 2\n\
        </DataArray><DataArray type='Int32' Name='offsets'>4 7 10</DataArray><DataArray type='UInt8' \
        Name='types'>7 7 5</DataArray></Cells>\n<CellData><DataArray type='UInt8' Name='vtkGhostType'>0 32 1\n\
        </DataArray></CellData></Piece></UnstructuredGrid></VTKFile>\n";
    let points = read("odd.vtu", text).unwrap();
    assert_eq!((points.dimension(), points.volumes()), (2, &[1.0][..]));
}

#[test]
fn a_path_that_leads_to_no_file() {
    for path in ["", "/", "no/such/file.inp", "/dev/null", "/dev/zero"] {
        match Points::read(path) {
            Err(Error::Io(text)) => assert!(text.contains(path), "{text}"),
            other => panic!("{path}: {other:?}"),
        }
    }
}

#[test]
fn names_of_sets_are_made_fit() {
    let long = "n".repeat(400);
    let text = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n2 1 \"{long}\"\n2 2 \"\"\n2 3 \"all\"\n\
         2 4 \"a\tb\"\n$EndPhysicalNames\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n5 2 1 0\n$EndNodes\n\
         $Elements\n5\n1 2 2 1 1 1 2 3\n2 2 2 2 1 2 4 3\n3 2 2 3 1 1 2 3\n4 2 2 4 1 2 5 4\n5 2 2 -4 1 2 4 3\n\
         $EndElements\n"
    );
    let points = read("names.msh", text).unwrap();
    // Elements 3 and 5 are 1 and 2 again, in other groups.
    assert_eq!(points.count(), 3);
    let names: Vec<&str> = points.set_names().collect();
    assert_eq!(names, ["a_b", "all_2", &"n".repeat(255), "unnamed"]);
    assert_eq!(points.set("a_b").unwrap(), [1, 2]);
    assert_eq!(points.set("all_2").unwrap(), [0]);
    assert_eq!(points.set("all").unwrap(), [0, 1, 2]);
}

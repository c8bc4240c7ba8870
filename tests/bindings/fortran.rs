//! Writes bindings/fortran/perion_c.f90: one Fortran interface for each item of the header.

use crate::header::{CType, Constant, Function, Header, Struct, Variable};
use std::collections::BTreeSet;

/// Numbers behind these names are arrays, `name(*)`.
const ARRAYS: &[&str] = &[
    "F0",
    "F1",
    "P",
    "W",
    "areas",
    "components",
    "coordinates",
    "field",
    "fields",
    "horizons",
    "indices",
    "integrity",
    "lower",
    "pairs",
    "positions",
    "reference_positions",
    "result",
    "state0",
    "state1",
    "stretch",
    "times",
    "upper",
    "values",
    "vertices",
    "volumes",
];

/// Numbers behind these names, and behind those that end in `_count` or `_size`, are one number.
const SCALARS: &[&str] = &["count", "dimension", "length", "size", "time", "time_step", "value"];

/// The last column that code reaches; Fortran allows 132.
const WIDTH: usize = 100;

const OPENING: &str = "\
! Generated from include/perion.h; do not edit. `make bindings` writes it anew.

!> The C interface of Perion, call by call. Most programs want the module `perion` instead.
!>
!> As in C: indices start at 0, text ends with `c_null_char`, an enumeration is an `integer(c_int32_t)`.
!> A handle is a `type(c_ptr)`; a callback is `c_funloc` of a procedure with the abstract interface of
!> that name. An argument whose name ends in `_or_null` may be absent; where it is passed by value,
!> `c_null_ptr` or `c_null_funptr` says so.
module perion_c
";

/// The whole file. Panics where the header holds something that has no agreed form in Fortran.
pub fn interfaces(header: &Header) -> String {
    refuse_unknown_names(header);
    let mut body = Writer { header, kinds: BTreeSet::new(), text: String::new() };
    body.module();
    let kinds: Vec<String> = body.kinds.into_iter().collect();
    let mut text = String::from(OPENING);
    text.push_str(&wrapped("  use, intrinsic :: iso_c_binding, only: ", &kinds, ""));
    text.push_str("  implicit none\n  public\n");
    text.push_str(&wrapped("  private :: ", &kinds, ""));
    text.push_str(&body.text);
    text.push_str("end module perion_c\n");
    text
}

struct Writer<'a> {
    header: &'a Header,
    /// What the module takes from iso_c_binding.
    kinds: BTreeSet<String>,
    text: String,
}

impl Writer<'_> {
    fn module(&mut self) {
        let header = self.header;
        let mut names = BTreeSet::new();
        let types = header.structs.iter().map(|it| &it.name);
        let procedures = header.callbacks.iter().chain(&header.functions).map(|it| &it.name);
        for name in types.chain(procedures) {
            assert!(names.insert(checked(name)), "two items are named {name} in Fortran");
        }
        for constant in &header.constants {
            let clash = names.contains(&checked(&constant.name));
            self.constant(constant, clash);
        }
        for it in &header.structs {
            self.derived_type(it);
        }
        self.interface("abstract interface", &header.callbacks, |_| String::from("bind(c)"));
        self.interface("interface", &header.functions, |name| format!("bind(c, name=\"{name}\")"));
        self.line("");
    }

    /// A constant is renamed where only its case sets it apart from a function.
    fn constant(&mut self, constant: &Constant, clash: bool) {
        let Constant { name, value, documentation } = constant;
        self.line("");
        self.document(2, documentation);
        let name = if clash {
            let note = format!("Not {name}: that is the function.");
            self.document(2, &[note]);
            format!("{name}_CONSTANT")
        } else {
            name.clone()
        };
        let (kind, literal) = if value.starts_with('"') {
            ("character(len=*)", value.clone())
        } else if value.parse::<i32>().is_ok() {
            ("integer(c_int32_t)", format!("{value}_c_int32_t"))
        } else if value.parse::<i64>().is_ok() {
            ("integer(c_int64_t)", format!("{value}_c_int64_t"))
        } else if value.parse::<f64>().is_ok() {
            ("real(c_double)", format!("{value}_c_double"))
        } else {
            panic!("{name}: the value {value} has no agreed form in Fortran")
        };
        self.kinds.extend(kind_in(kind));
        self.line(&format!("  {kind}, parameter :: {} = {literal}", checked_case(&name)));
    }

    fn derived_type(&mut self, it: &Struct) {
        self.line("");
        self.document(2, &it.documentation);
        self.line(&format!("  type, bind(c) :: {}", it.name));
        for field in &it.fields {
            self.document(4, &field.documentation);
            let ctype = if field.ctype.pointers > 0 {
                String::from("type(c_ptr)")
            } else {
                self.by_value(&field.ctype).unwrap_or_else(|| refuse(&it.name, field))
            };
            self.kinds.extend(kind_in(&ctype));
            let length = field.length.as_ref().map_or(String::new(), |n| format!("({n})"));
            self.line(&format!("    {ctype} :: {}{length}", checked_case(&field.name)));
        }
        self.line(&format!("  end type {}", it.name));
    }

    fn interface(&mut self, opening: &str, list: &[Function], binding: impl Fn(&str) -> String) {
        if list.is_empty() {
            return;
        }
        self.line("");
        self.line(&format!("  {opening}"));
        for function in list {
            self.procedure(function, &binding(&function.name));
        }
        self.line("");
        self.line("  end interface");
    }

    fn procedure(&mut self, function: &Function, binding: &str) {
        let Function { name, result, parameters, documentation } = function;
        let mut imports = BTreeSet::new();
        let mut declarations = Vec::new();
        let mut names = BTreeSet::from([checked(name)]);
        for parameter in parameters {
            let (ctype, dummy) = self.dummy(name, parameter);
            assert!(names.insert(checked(&parameter.name)), "{name}: {dummy} is named twice");
            declarations.push(format!("      {ctype} :: {dummy}"));
            imports.extend(import_of(&ctype));
            self.kinds.extend(kind_in(&ctype));
        }
        let form = if result.base == "void" && result.pointers == 0 {
            "subroutine"
        } else {
            let ctype = self.result(name, result);
            declarations.push(format!("      {ctype} :: {name}"));
            imports.extend(import_of(&ctype));
            self.kinds.extend(kind_in(&ctype));
            "function"
        };
        self.line("");
        self.document(4, documentation);
        let dummies: Vec<String> = parameters.iter().map(|it| it.name.clone()).collect();
        let head = format!("    {form} {name}(");
        self.text.push_str(&wrapped(&head, &dummies, &format!(") {binding}")));
        if !imports.is_empty() {
            let imports: Vec<String> = imports.into_iter().collect();
            self.text.push_str(&wrapped("      import :: ", &imports, ""));
        }
        for declaration in declarations {
            self.line(&declaration);
        }
        self.line(&format!("    end {form} {name}"));
    }

    /// A parameter's type with its attributes, and its name with its shape.
    fn dummy(&self, function: &str, parameter: &Variable) -> (String, String) {
        let Variable { name, ctype, .. } = parameter;
        let intent = if ctype.constant { "intent(in)" } else { "intent(inout)" };
        let optional = if name.ends_with("_or_null") { "optional, " } else { "" };
        let base = self.header.resolve(&ctype.base);
        let form = match ctype.pointers {
            0 => self.by_value(ctype).map(|of| (format!("{of}, value"), name.clone())),
            1 if base == "void" || self.header.handles.iter().any(|it| it == base) => {
                let constant = if ctype.constant { ", intent(in)" } else { "" };
                Some((format!("type(c_ptr), value{constant}"), name.clone()))
            }
            1 => self.by_value(&CType { base: base.to_owned(), constant: false, pointers: 0 }).map(
                |of| {
                    let array = base == "char" || (scalar(base).is_some() && is_array(name));
                    let shape = if array { "(*)" } else { "" };
                    (format!("{of}, {optional}{intent}"), format!("{name}{shape}"))
                },
            ),
            2 => Some((format!("type(c_ptr), {optional}intent(inout)"), name.clone())),
            _ => None,
        };
        form.unwrap_or_else(|| refuse(function, parameter))
    }

    fn result(&self, function: &str, ctype: &CType) -> String {
        match ctype.pointers {
            0 => scalar(self.header.resolve(&ctype.base)).map(str::to_owned),
            _ => Some(String::from("type(c_ptr)")),
        }
        .unwrap_or_else(|| panic!("{function}: a {ctype:?} cannot be returned to Fortran"))
    }

    /// The type of something that is there itself, not behind a pointer.
    fn by_value(&self, ctype: &CType) -> Option<String> {
        let base = self.header.resolve(&ctype.base);
        if self.header.callbacks.iter().any(|it| it.name == base) {
            Some(String::from("type(c_funptr)"))
        } else if self.header.structs.iter().any(|it| it.name == base) {
            Some(format!("type({base})"))
        } else {
            scalar(base).map(str::to_owned)
        }
    }

    fn document(&mut self, indent: usize, lines: &[String]) {
        let margin = format!("{:indent$}!>", "");
        for line in lines {
            let mut column = margin.clone();
            for word in line.split(' ') {
                if column.chars().count() + 1 + word.chars().count() > 132 {
                    self.line(column.trim_end());
                    column.clone_from(&margin);
                }
                column.push(' ');
                column.push_str(word);
            }
            self.line(column.trim_end());
        }
    }

    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }
}

/// Plain C numbers, truth values and characters; unsigned ones and `size_t` have no Fortran kind.
fn scalar(base: &str) -> Option<&'static str> {
    Some(match base {
        "bool" => "logical(c_bool)",
        "char" => "character(kind=c_char)",
        "double" => "real(c_double)",
        "float" => "real(c_float)",
        "int" => "integer(c_int)",
        "int32_t" => "integer(c_int32_t)",
        "int64_t" => "integer(c_int64_t)",
        _ => return None,
    })
}

/// Panics with every name that stands in neither list.
fn refuse_unknown_names(header: &Header) {
    let mut unknown = BTreeSet::new();
    for function in header.callbacks.iter().chain(&header.functions) {
        for Variable { name, ctype, .. } in &function.parameters {
            let base = header.resolve(&ctype.base);
            let number = ctype.pointers == 1 && base != "char" && scalar(base).is_some();
            if number && !is_array(name) && (ctype.constant || !is_one(name)) {
                unknown.insert(format!("{}: {name}", function.name));
            }
        }
    }
    assert!(
        unknown.is_empty(),
        "an array or one number? Give these parameters names of ARRAYS or SCALARS, or add theirs \
         there, in tests/bindings/fortran.rs (a const one is an array): {unknown:#?}"
    );
}

fn is_array(name: &str) -> bool {
    ARRAYS.contains(&name.strip_suffix("_or_null").unwrap_or(name))
}

fn is_one(name: &str) -> bool {
    let plain = name.strip_suffix("_or_null").unwrap_or(name);
    SCALARS.contains(&plain) || plain.ends_with("_count") || plain.ends_with("_size")
}

fn refuse(place: &str, it: &Variable) -> ! {
    panic!("{place}: `{}`, a {:?}, has no agreed form in Fortran", it.name, it.ctype)
}

/// What `type(c_ptr), value` or `integer(c_int), value` needs: the word in the first parentheses.
fn import_of(ctype: &str) -> Option<String> {
    let (_, inner) = ctype.split_once('(')?;
    let (inner, _) = inner.split_once(')')?;
    Some(inner.trim_start_matches("kind=").to_owned())
}

/// The same where it comes from iso_c_binding.
fn kind_in(ctype: &str) -> Option<String> {
    import_of(ctype).filter(|name| name.starts_with("c_"))
}

/// The name as Fortran compares it; panics where it is none.
fn checked(name: &str) -> String {
    let plain = name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
    let begins = name.starts_with(|letter: char| letter.is_ascii_alphabetic());
    assert!(plain && begins && name.len() <= 63, "`{name}` is not a Fortran name");
    name.to_ascii_lowercase()
}

fn checked_case(name: &str) -> &str {
    checked(name);
    name
}

/// A comma-separated list between `head` and `tail`, continued on further lines where it is long.
/// Of the tail, what stands before the first blank stays with the last item.
fn wrapped(head: &str, items: &[String], tail: &str) -> String {
    let indent = head.len() - head.trim_start().len() + 4;
    let (closing, rest) = tail.split_once(' ').unwrap_or((tail, ""));
    let list = items.join(",\n") + closing;
    let mut text = String::new();
    let mut line = head.trim_end().to_owned();
    for (place, piece) in list.lines().chain([rest]).enumerate() {
        let blank = if place > 0 || head.ends_with(' ') { " " } else { "" };
        // Two columns more are for the ` &` of a line that goes on.
        if line.len() + blank.len() + piece.len() + 2 > WIDTH {
            text.push_str(&line);
            text.push_str(" &\n");
            line = format!("{:indent$}{piece}", "");
        } else {
            line.push_str(blank);
            line.push_str(piece);
        }
    }
    text + line.trim_end() + "\n"
}

//! Reads include/perion.h: just the C that cbindgen writes for this crate, and no more.

/// What the header declares, in its order.
#[derive(Default)]
pub struct Header {
    pub constants: Vec<Constant>,
    /// Opaque structs, by name.
    pub handles: Vec<String>,
    /// Names of integer types: the alias and the C type behind it.
    pub aliases: Vec<(String, String)>,
    pub structs: Vec<Struct>,
    /// Types of pointers to functions of the host.
    pub callbacks: Vec<Function>,
    pub functions: Vec<Function>,
}

/// `#define name value`.
pub struct Constant {
    pub name: String,
    pub value: String,
    pub documentation: Vec<String>,
}

/// A struct whose fields the host sees.
pub struct Struct {
    pub name: String,
    pub fields: Vec<Variable>,
    pub documentation: Vec<String>,
}

/// A function of the library, or one that the host gives.
pub struct Function {
    pub name: String,
    pub result: CType,
    pub parameters: Vec<Variable>,
    pub documentation: Vec<String>,
}

/// A parameter or a field.
pub struct Variable {
    pub name: String,
    pub ctype: CType,
    /// `Some(3)` for a field `double direction[3]`.
    pub length: Option<String>,
    pub documentation: Vec<String>,
}

/// `const double *` is base `double`, constant, one pointer.
#[derive(Debug)]
pub struct CType {
    pub base: String,
    pub constant: bool,
    pub pointers: usize,
}

impl Header {
    /// Panics with the offending declaration where the header holds C that is not expected here.
    pub fn parse(text: &str) -> Header {
        let mut header = Header::default();
        for declaration in declarations(text) {
            header.add(declaration);
        }
        header
    }

    /// The C type behind an alias, or the type itself.
    pub fn resolve<'a>(&'a self, base: &'a str) -> &'a str {
        self.aliases.iter().find(|(name, _)| name == base).map_or(base, |(_, behind)| behind)
    }

    /// The value of a constant, as it stands in the header.
    pub fn constant(&self, name: &str) -> Option<&str> {
        self.constants.iter().find(|constant| constant.name == name).map(|found| &*found.value)
    }

    fn add(&mut self, declaration: Declaration) {
        let Declaration { documentation, text } = declaration;
        if let Some(definition) = text.strip_prefix("#define ") {
            // The include guard has no value.
            if let Some((name, value)) = definition.split_once(' ') {
                let (name, value) = (name.to_owned(), value.trim().to_owned());
                self.constants.push(Constant { name, value, documentation });
            }
        } else if let Some(typedef) = text.strip_prefix("typedef ") {
            self.add_typedef(typedef, documentation);
        } else {
            self.functions.push(function(&text, documentation));
        }
    }

    fn add_typedef(&mut self, text: &str, documentation: Vec<String>) {
        if let Some((opening, rest)) = text.split_once('{') {
            let (body, name) = rest.rsplit_once('}').unwrap_or_else(|| unexpected(text));
            assert!(opening.starts_with("struct "), "not a struct: {text}");
            let fields = declarations(body).into_iter().map(field).collect();
            self.structs.push(Struct { name: name.trim().to_owned(), fields, documentation });
        } else if let Some((result, rest)) = text.split_once("(*") {
            let (name, parameters) = rest.split_once(')').unwrap_or_else(|| unexpected(text));
            self.callbacks.push(function(&format!("{result}{name}{parameters}"), documentation));
        } else {
            let alias = variable(text);
            if text.starts_with("struct ") {
                self.handles.push(alias.name);
            } else {
                self.aliases.push((alias.name, alias.ctype.base));
            }
        }
    }
}

struct Declaration {
    documentation: Vec<String>,
    text: String,
}

/// Splits at the semicolons outside braces; a `#define` is a declaration of its own.
fn declarations(text: &str) -> Vec<Declaration> {
    let mut found = Vec::new();
    let mut documentation = Vec::new();
    let mut pending = String::new();
    let mut depth = 0;
    let (mut in_comment, mut in_cplusplus) = (false, false);
    for line in text.lines() {
        let trimmed = line.trim();
        if in_cplusplus {
            in_cplusplus = !trimmed.starts_with("#endif");
        } else if in_comment || trimmed.starts_with("/*") {
            if !pending.is_empty() {
                // A field's comment stays with the body, which is split in its turn.
                pending.push_str(line);
                pending.push('\n');
            } else if !in_comment {
                documentation.clear();
            } else if !trimmed.ends_with("*/") {
                let words = trimmed.strip_prefix('*').unwrap_or(trimmed);
                documentation.push(words.strip_prefix(' ').unwrap_or(words).to_owned());
            }
            in_comment = !trimmed.ends_with("*/");
        } else if trimmed.starts_with("#define ") {
            let documentation = std::mem::take(&mut documentation);
            found.push(Declaration { documentation, text: trimmed.to_owned() });
        } else if trimmed.starts_with('#') {
            in_cplusplus = trimmed == "#ifdef __cplusplus";
        } else if !trimmed.is_empty() {
            depth += trimmed.matches('{').count();
            depth -= trimmed.matches('}').count();
            pending.push_str(trimmed);
            pending.push('\n');
            if depth == 0 && trimmed.ends_with(';') {
                let text = pending.trim_end().trim_end_matches(';').to_owned();
                pending.clear();
                found.push(Declaration { documentation: std::mem::take(&mut documentation), text });
            }
        }
    }
    assert!(pending.is_empty(), "the header ends inside: {pending}");
    found
}

fn field(declaration: Declaration) -> Variable {
    Variable { documentation: declaration.documentation, ..variable(&declaration.text) }
}

/// `result name(parameters)`.
fn function(text: &str, documentation: Vec<String>) -> Function {
    let (head, rest) = text.split_once('(').unwrap_or_else(|| unexpected(text));
    let list = rest.strip_suffix(')').unwrap_or_else(|| unexpected(text));
    assert!(!list.contains('('), "give the function pointer a type of its own: {text}");
    let parameters = match list.trim() {
        "void" => Vec::new(),
        list => list.split(',').map(variable).collect(),
    };
    let head = variable(head);
    Function { name: head.name, result: head.ctype, parameters, documentation }
}

/// `const struct perion_points *points`, `double direction[3]`.
fn variable(text: &str) -> Variable {
    let text = text.trim();
    let (text, length) = match text.split_once('[') {
        Some((before, after)) => (before, after.strip_suffix(']').map(str::to_owned)),
        None => (text, None),
    };
    let spaced = text.replace('*', " * ");
    let words: Vec<&str> = spaced.split_whitespace().filter(|&word| word != "struct").collect();
    let (base, constant, rest) = match *words {
        ["const", base, ref rest @ ..] => (base, true, rest),
        [base, ref rest @ ..] => (base, false, rest),
        [] => unexpected(text),
    };
    let (name, stars) = rest.split_last().unwrap_or_else(|| unexpected(text));
    assert!(stars.iter().all(|&word| word == "*"), "a type that is not provided for: {text}");
    let ctype = CType { base: base.to_owned(), constant, pointers: stars.len() };
    Variable { name: (*name).to_owned(), ctype, length, documentation: Vec::new() }
}

fn unexpected(text: &str) -> ! {
    panic!("tests/bindings/header.rs cannot read: {text}")
}

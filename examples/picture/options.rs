//! What the command line asks for.

use crate::view::View;

pub const USAGE: &str = "\
usage: picture INPUT OUTPUT.png [options]

INPUT is a .vtu file that Perion wrote, drawn as points in the x-y plane, or a .csv file:
  --curve                   its second column over its first; the first line names them
  --series                  sizes of its third and fourth column on logarithmic axes: a colour for each word in
                            the first, a line for each word in the second
  --curves                  all its columns over its first
  --logarithmic             sizes of its values, on a logarithmic axis
  --map                     its rows, from below, as colours; its first line is
                            'label across,first,last,label up,first,last,label of the values'

  --field NAME              colour by this field (damage); NAME is the magnitude of a vector,
                            NAME.x, NAME.y, NAME.z or NAME.0, NAME.1, ... one component
  --range LO HI             values at the ends of the colours (least and greatest value drawn)
  --width PIXELS            width of the picture, 320 to 4096 (1600)
  --title TEXT              what stands above it
  --scale-displacement S    show the field 'displacement' S times as large
  --slice Z                 only the layer of points nearest to this height
  --view TURN TILT          a body from aside: turned about the upright axis, and seen from above, in degrees
  --right AXIS              which axis points right in a view (x), the next one points up";

#[derive(Clone, Copy)]
pub enum Kind {
    Points,
    Curve,
    Series,
    Curves,
    Map,
}

pub struct Options {
    pub input: String,
    pub output: String,
    pub kind: Kind,
    pub field: String,
    pub range: Option<(f64, f64)>,
    pub width: usize,
    pub title: Option<String>,
    pub logarithmic: bool,
    pub displacement_scale: Option<f64>,
    pub slice: Option<f64>,
    pub view: Option<View>,
}

pub enum Request {
    Help,
    Draw(Options),
}

impl Request {
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut options = Options {
            input: String::new(),
            output: String::new(),
            kind: Kind::Points,
            field: "damage".into(),
            range: None,
            width: 1600,
            title: None,
            logarithmic: false,
            displacement_scale: None,
            slice: None,
            view: None,
        };
        let mut right = 0;
        let mut files = Vec::new();
        while let Some(argument) = arguments.next() {
            let option = argument.as_str();
            let mut value =
                || arguments.next().ok_or(format!("{option} needs a value; see --help"));
            match option {
                "--help" | "-h" => return Ok(Self::Help),
                "--curve" => options.kind = Kind::Curve,
                "--series" => options.kind = Kind::Series,
                "--curves" => options.kind = Kind::Curves,
                "--logarithmic" => options.logarithmic = true,
                "--map" => options.kind = Kind::Map,
                "--field" => options.field = value()?,
                "--title" => options.title = Some(value()?),
                "--range" => {
                    let (low, high) = (number(option, &value()?)?, number(option, &value()?)?);
                    if low >= high {
                        return Err(format!("--range {low} {high}: the first must be less"));
                    }
                    options.range = Some((low, high));
                }
                "--width" => {
                    let given = value()?;
                    options.width = given
                        .parse()
                        .ok()
                        .filter(|width| (320..=4096).contains(width))
                        .ok_or(format!("--width {given}: must be a number from 320 to 4096"))?;
                }
                "--scale-displacement" => {
                    options.displacement_scale = Some(number(option, &value()?)?);
                }
                "--view" => {
                    let (turn, tilt) = (number(option, &value()?)?, number(option, &value()?)?);
                    options.view = Some(View { right, turn, tilt });
                }
                "--right" => {
                    let given = value()?;
                    right = ["x", "y", "z"]
                        .iter()
                        .position(|axis| *axis == given)
                        .ok_or(format!("--right {given}: must be x, y or z"))?;
                }
                "--slice" => options.slice = Some(number(option, &value()?)?),
                _ if option.starts_with("--") => {
                    return Err(format!("unknown option {option}; see --help"));
                }
                _ => files.push(argument),
            }
        }
        [options.input, options.output] = <[String; 2]>::try_from(files).map_err(|files| {
            format!("needs INPUT and OUTPUT.png, not {} file names; see --help", files.len())
        })?;
        options.view = options.view.map(|view| View { right, ..view });
        Ok(Self::Draw(options))
    }
}

fn number(option: &str, text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value: &f64| value.is_finite());
    value.ok_or(format!("{option} {text}: must be a finite number"))
}

//! Files with small and large damage: whatever is in them, a reader gives points or says what is
//! wrong, soon, and asks for no memory that the file could not fill.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::fs;
use std::panic::catch_unwind;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::common::{in_crate, place};
use perion::{Error, Points};

/// The system's allocator, which remembers the largest request of each thread.
struct Watched;

thread_local! {
    static LARGEST: Cell<usize> = const { Cell::new(0) };
}

fn remember(size: usize) {
    // There is nothing to count while a thread ends.
    let _ = LARGEST.try_with(|largest| largest.set(largest.get().max(size)));
}

// SAFETY: everything is the system allocator's own.
unsafe impl GlobalAlloc for Watched {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        remember(layout.size());
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        remember(size);
        // SAFETY: the caller's promise.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Watched = Watched;

/// Mutants of each file.
const MUTANTS: u64 = 250;
/// Reading a sound file of these takes about a millisecond.
const LONGEST: Duration = Duration::from_secs(5);
/// The largest array is twice the numbers of cells or nodes, of 32 bytes each; a number has two bytes of a
/// file at least.
const BYTES_A_BYTE: usize = 32;
/// ZLib packs up to this many bytes into one.
const BYTES_A_PACKED_BYTE: usize = 1100;

#[test]
fn mutants_of_text_files_are_read_or_refused() {
    hold(&["cloud.txt", "cloud.csv", "plane.dat"], BYTES_A_BYTE);
}

#[test]
fn mutants_of_abaqus_files_are_read_or_refused() {
    hold(&["tetrahedron.inp", "hexahedron.inp", "triangle6.inp"], BYTES_A_BYTE);
}

#[test]
fn mutants_of_gmsh_files_are_read_or_refused() {
    hold(
        &[
            "tetrahedron_4.1_text.msh",
            "tetrahedron_2.2_binary.msh",
            "triangle6_4.1_binary.msh",
            "triangle6_2.2_text.msh",
        ],
        BYTES_A_BYTE,
    );
}

#[test]
fn mutants_of_vtk_files_are_read_or_refused() {
    hold(
        &[
            "solids_default.vtu",
            "solids_ascii.vtu",
            "planes_raw.vtu",
            "vertices_wide.vtu",
            "cloud_big_endian.vtu",
        ],
        BYTES_A_PACKED_BYTE,
    );
}

fn hold(names: &[&str], bytes_a_byte: usize) {
    let place = place(&format!("readers/mutated_{}", names[0]));
    let (mut read, mut refused) = (0, 0);
    for name in names {
        let sound = fs::read(in_crate("tests/data/meshes").join(name)).unwrap();
        for seed in 0..MUTANTS {
            let mut chance = Chance(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) + 1);
            let mut mutant = sound.clone();
            for _ in 0..=chance.below(3) {
                mutate(&mut mutant, &mut chance);
            }
            let path = place.join(name);
            fs::write(&path, &mutant).unwrap();
            match outcome(&path, bytes_a_byte * (mutant.len() + 4096)) {
                Ok(()) => read += 1,
                Err(Error::Format(text) | Error::Unsupported(text)) => {
                    assert!(text.contains(name), "{name}, {seed}: {text}");
                    refused += 1;
                }
                Err(error) => panic!("{name}, {seed}: {error}"),
            }
        }
    }
    // Neither are all mutations harmless, nor is everything refused.
    assert!(read > 10 && refused > 10 * names.len(), "{read} read, {refused} refused");
}

fn outcome(path: &Path, most_bytes: usize) -> Result<(), Error> {
    LARGEST.set(0);
    let start = Instant::now();
    let read = catch_unwind(|| Points::read(path));
    let read = read.unwrap_or_else(|_| panic!("{} made the reader panic", path.display()));
    let (spent, largest) = (start.elapsed(), LARGEST.get());
    assert!(spent < LONGEST, "{} took {spent:?}", path.display());
    assert!(largest <= most_bytes, "{} asked for {largest} bytes", path.display());
    let points = read?;
    assert!(points.volumes().iter().all(|volume| volume.is_finite() && *volume > 0.0));
    assert!(points.coordinates().iter().all(|place| place.is_finite()));
    Ok(())
}

/// Does one thing to a file.
fn mutate(file: &mut Vec<u8>, chance: &mut Chance) {
    const NUMBERS: [&str; 12] = [
        "-1",
        "0",
        "4294967295",
        "4294967296",
        "99999999999999999999",
        "1e308",
        "-1e-308",
        "nan",
        "inf",
        "1.5",
        "x",
        "",
    ];
    if file.is_empty() {
        return;
    }
    let place = chance.below(file.len());
    let span = place..file.len().min(place + 1 + chance.below(64));
    match chance.below(10) {
        0 => file[place] ^= 1 << chance.below(8),
        1 => file[place] = chance.below(256) as u8,
        2 => drop(file.drain(span)),
        3 => {
            let piece = file[span].to_vec();
            file.splice(place..place, piece);
        }
        4 => file.truncate(place),
        5 => file[span].fill(0),
        6 => file[span].fill(0xff),
        // A line twice, or not at all.
        7 | 8 => {
            let start = file[..place].iter().rposition(|&it| it == b'\n').map_or(0, |it| it + 1);
            let length = file[start..].iter().position(|&it| it == b'\n').map_or(0, |it| it + 1);
            let line: Vec<u8> = file.drain(start..start + length).collect();
            if chance.below(2) == 0 {
                file.splice(start..start, [&line[..], &line[..]].concat());
            }
        }
        // Another number in place of one.
        _ => {
            let digit = |byte: &u8| byte.is_ascii_digit();
            let Some(start) = file[place..].iter().position(digit) else { return };
            let start = place + start;
            let length = file[start..].iter().position(|it| !digit(it)).unwrap_or(1);
            let number = NUMBERS[chance.below(NUMBERS.len())];
            file.splice(start..start + length, number.bytes());
        }
    }
}

/// Numbers that are the same in every run.
struct Chance(u64);

impl Chance {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % limit
    }
}

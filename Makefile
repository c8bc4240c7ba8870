# The commands of the README: `make install`, `make demo`, `make examples` and `make test`. cargo alone builds the library.

PREFIX ?= /usr/local
LIBDIR = $(PREFIX)/lib
INCLUDEDIR = $(PREFIX)/include
DESTDIR ?=
CARGO ?= cargo
ifeq ($(origin FC),default)
FC := gfortran
endif
CFLAGS ?= -O2 -Wall -Wextra
FFLAGS ?= -O2 -Wall -Wextra

VERSION := $(shell sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
ABI := $(shell sed -n 's/^const ABI_VERSION: &str = "\(.*\)";/\1/p' build.rs)
TARGET := $(or $(CARGO_TARGET_DIR),$(CURDIR)/target)
LIB := $(TARGET)/release
OUT := out

# Sources in bindings/fortran that hosts compile, in the order in which compilers want them. perion.pc and the
# CMake files take this list; fpm finds its own order.
FORTRAN_SOURCES := perion_c.f90 perion_support.f90 perion.f90 perion_library.f90 perion_points.f90 perion_model.f90 perion_setup.f90 perion_conditions.f90 perion_fields.f90 perion_drive.f90 perion_statics.f90
# What the static library needs of the system: rustc's native-static-libs.
NATIVE_LIBRARIES := -lgcc_s -lutil -lrt -lpthread -lm -ldl -lc

BUILD := $(CARGO) build --release --target-dir "$(TARGET)"

# A library for another machine is cargo's own business.
unexport CARGO_BUILD_TARGET

.PHONY: all library demo examples test test-long install uninstall bench bench-peers work-precision bindings clean

all: library
	@echo "built: $(LIB)/libperion.so"
	@echo "next:  make install PREFIX=$$HOME/.local, and from there README.md, section \"Install and link\""

library:
	@command -v $(firstword $(CARGO)) > /dev/null || { \
	  echo "cargo is missing: install Rust 1.89 or later (rustup), or say where it is by CARGO=..."; exit 1; }
	$(BUILD) --lib
	@test -f "$(LIB)/libperion.so" || { \
	  echo "cargo has built for another machine: its configuration names a build.target, which to build for this one" \
	  "must not"; exit 1; }
	@ln -sf libperion.so "$(LIB)/libperion.so.$(ABI)"

EXAMPLE_RUNS = CARGO="$(CARGO)" CC="$(CC)" CFLAGS="$(CFLAGS)" FC="$(FC)" FFLAGS="$(FFLAGS)" \
	TARGET="$(TARGET)" FORTRAN_SOURCES="$(FORTRAN_SOURCES)" OUT="$(OUT)" sh scripts/demo.sh

# A specimen is pulled apart and a plate branches, from C, Fortran and Rust; the hashes are equal.
demo: library
	@$(EXAMPLE_RUNS) specimen branching

# The same of all examples, or of those named: make examples EXAMPLES="twist bend".
EXAMPLES := checkerboard twist bend wave own_material traction_bar hyperelastic_bar patch beam specimen branching
examples: library
	@$(EXAMPLE_RUNS) $(EXAMPLES)

# Everything: style, unit tests, reference numbers, properties, C, Fortran, installation, README.
test: library
	@CARGO="$(CARGO)" TARGET="$(TARGET)" sh scripts/test.sh

# What takes too long for every day; docs tell what it last gave.
test-long:
	$(CARGO) test --release --test stable_step --test statics -- --ignored --nocapture --test-threads 1

# Installs what is built, and builds what is not or is older than its sources: as root, run make first as yourself.
INSTALLATION = MAKE="$(MAKE)" CARGO="$(CARGO)" LIB="$(LIB)" VERSION="$(VERSION)" ABI="$(ABI)" \
	PREFIX="$(PREFIX)" LIBDIR="$(LIBDIR)" INCLUDEDIR="$(INCLUDEDIR)" DESTDIR="$(DESTDIR)" \
	FORTRAN_SOURCES="$(FORTRAN_SOURCES)" NATIVE_LIBRARIES="$(NATIVE_LIBRARIES)"
install:
	+@$(INSTALLATION) sh scripts/install.sh install

uninstall:
	+@$(INSTALLATION) sh scripts/install.sh uninstall

# The table of speed, memory and set-up, or a part of it: make bench BENCH="bond_based cloud 50".
bench:
	$(CARGO) bench --target-dir "$(TARGET)" --bench throughput -- $(BENCH)

# The same scenes by other codes that are installed, in turns: make bench-peers BENCH="cloud pmb".
bench-peers:
	$(CARGO) bench --target-dir "$(TARGET)" --bench peers -- $(BENCH)

# What error each formulation has for its seconds, on problems with known answers, in out/accuracy with pictures; or a part:
# make work-precision PROBLEMS="plane_wave traction_bar".
work-precision:
	$(CARGO) bench --target-dir "$(TARGET)" --bench work_precision -- "$(CURDIR)/$(OUT)/accuracy" $(PROBLEMS)
	@$(BUILD) --quiet --example picture
	@cd "$(OUT)/accuracy" && for table in *_*.csv; do \
	  "$(LIB)/examples/picture" "$$table" "$${table%.csv}.png" --series --title "$${table%.csv}" && \
	  echo "picture:   $(OUT)/accuracy/$${table%.csv}.png"; done

# Writes the header and the Fortran interfaces anew from src/ffi.
bindings:
	PERION_BLESS=1 $(CARGO) test --release --test bindings committed

clean:
	$(CARGO) clean
	rm -rf out

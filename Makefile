# The commands of the README: `make demo` and `make test`. cargo alone builds the library.

PREFIX ?= /usr/local
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
OUT := out/branching
BUILD := $(CARGO) build --release --target-dir "$(TARGET)"

# A library for another machine is cargo's own business.
unexport CARGO_BUILD_TARGET

.PHONY: all library demo test install bench bindings clean

all: library

library:
	$(BUILD) --lib
	@ln -sf libperion.so "$(LIB)/libperion.so.$(ABI)"

# A plate cracks and branches, computed from C, Fortran and Rust; the hashes are equal.
demo: library
	@CARGO="$(CARGO)" CC="$(CC)" CFLAGS="$(CFLAGS)" FC="$(FC)" FFLAGS="$(FFLAGS)" TARGET="$(TARGET)" \
	OUT="$(OUT)" sh scripts/demo.sh

# Everything: style, unit tests, reference numbers, properties, C, Fortran, installation, README.
test: library
	@CARGO="$(CARGO)" TARGET="$(TARGET)" sh scripts/test.sh

# Installs what is built, and builds only what is not: as root, run make first as yourself.
TO = $(DESTDIR)$(PREFIX)
install:
	@case "$(PREFIX)" in /*) ;; *) echo "PREFIX must be an absolute path, not '$(PREFIX)'"; exit 1 ;; esac
	@test -f "$(LIB)/libperion.so" -a -f "$(LIB)/libperion.a" || $(MAKE) library
	install -d "$(TO)/lib/pkgconfig" "$(TO)/include" "$(TO)/share/perion/fortran"
	install -m 755 "$(LIB)/libperion.so" "$(TO)/lib/libperion.so.$(VERSION)"
	ln -sf libperion.so.$(VERSION) "$(TO)/lib/libperion.so.$(ABI)"
	ln -sf libperion.so.$(ABI) "$(TO)/lib/libperion.so"
	install -m 644 "$(LIB)/libperion.a" "$(TO)/lib/libperion.a"
	install -m 644 include/perion.h "$(TO)/include/perion.h"
	install -m 644 bindings/fortran/perion_c.f90 "$(TO)/share/perion/fortran/"
	sed -e 's|@PREFIX@|$(PREFIX)|' -e 's|@VERSION@|$(VERSION)|' bindings/pkgconfig/perion.pc.in \
		> "$(TO)/lib/pkgconfig/perion.pc"

bench:
	$(CARGO) bench --bench throughput

# Writes the header and the Fortran interfaces anew from src/ffi.
bindings:
	PERION_BLESS=1 $(CARGO) test --release --test bindings committed

clean:
	$(CARGO) clean
	rm -rf out

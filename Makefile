# The commands of the README: `make demo` and `make test`. cargo alone builds the library.

PREFIX ?= /usr/local
DESTDIR ?=
CARGO ?= cargo
CC ?= cc
FC := gfortran
CFLAGS ?= -O2 -Wall -Wextra
FFLAGS ?= -O2 -Wall -Wextra

VERSION := $(shell sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
ABI := $(shell sed -n 's/^const ABI_VERSION: &str = "\(.*\)";/\1/p' build.rs)
TARGET := $(or $(CARGO_TARGET_DIR),target)
LIB := $(TARGET)/release
LINK := -L$(LIB) -lperion -lm -Wl,-rpath,$(abspath $(LIB))
OUT := out/branching

.PHONY: all library demo test install bench bindings clean

all: library

library:
	$(CARGO) build --release --lib
	@ln -sf libperion.so $(LIB)/libperion.so.$(ABI)

# A plate cracks and branches, computed from C, Fortran and Rust; the hashes are equal.
demo: library
	@CARGO="$(CARGO)" CC="$(CC)" CFLAGS="$(CFLAGS)" FC="$(FC)" FFLAGS="$(FFLAGS)" LINK="$(LINK)" \
	LIB="$(LIB)" OUT="$(OUT)" sh scripts/demo.sh

# Everything: style, unit tests, reference numbers, properties, C, Fortran, installation, README.
test: library
	@CARGO="$(CARGO)" sh scripts/test.sh

install: library
	install -d $(DESTDIR)$(PREFIX)/lib/pkgconfig $(DESTDIR)$(PREFIX)/include \
		$(DESTDIR)$(PREFIX)/share/perion/fortran
	install -m 755 $(LIB)/libperion.so $(DESTDIR)$(PREFIX)/lib/libperion.so.$(VERSION)
	ln -sf libperion.so.$(VERSION) $(DESTDIR)$(PREFIX)/lib/libperion.so.$(ABI)
	ln -sf libperion.so.$(ABI) $(DESTDIR)$(PREFIX)/lib/libperion.so
	install -m 644 $(LIB)/libperion.a $(DESTDIR)$(PREFIX)/lib/libperion.a
	install -m 644 include/perion.h $(DESTDIR)$(PREFIX)/include/perion.h
	install -m 644 bindings/fortran/perion_c.f90 $(DESTDIR)$(PREFIX)/share/perion/fortran/
	sed -e 's|@PREFIX@|$(PREFIX)|' -e 's|@VERSION@|$(VERSION)|' bindings/pkgconfig/perion.pc.in \
		> $(DESTDIR)$(PREFIX)/lib/pkgconfig/perion.pc

bench:
	$(CARGO) bench --bench throughput

# Writes the header and the Fortran interfaces anew from src/ffi.
bindings:
	PERION_BLESS=1 $(CARGO) test --release --test bindings committed

clean:
	$(CARGO) clean
	rm -rf out

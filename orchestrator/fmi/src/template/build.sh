#!/bin/sh
# Compiles @name@.c and packs @name@.fmu. Needs a C compiler (or set CC), and python3 or zip.
set -eu
cd "$(dirname "$0")"
binaries="fmu/binaries/$(uname -m)-linux"
mkdir -p "$binaries"
${CC:-cc} -shared -fPIC -O2 -o "$binaries/@name@.so" @name@.c -lm
rm -f @name@.fmu
cd fmu
if command -v python3 >/dev/null; then
    python3 -m zipfile -c ../@name@.fmu *
else
    zip -qr ../@name@.fmu *
fi
echo "wrote @name@.fmu"

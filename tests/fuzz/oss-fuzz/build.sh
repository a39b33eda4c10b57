#!/usr/bin/env bash
# OSS-Fuzz's build: $OUT gets a program for each target, its seeds and options, and in lib the libraries that it is linked to.
set -euo pipefail
export CXXFLAGS="${CXXFLAGS//-stdlib=libc++/}"  # the distribution's libraries are built with libstdc++
cmake -S "$SRC/hexrelief" -B "$WORK/build" -G Ninja -DHEXRELIEF_FUZZ=ON -DHEXRELIEF_SANITIZE=ON -DHEXRELIEF_CUDA=OFF \
    -DHEXRELIEF_BUILD_FOLDER= -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG="-O1 -g1" \
    -DCMAKE_EXE_LINKER_FLAGS='-Wl,-rpath,$ORIGIN/lib -Wl,--disable-new-dtags'
cmake --build "$WORK/build" --target hexrelief_fuzz
program=$WORK/build/tests/fuzz/hexrelief_fuzz

mkdir -p "$OUT/lib"
ldd "$program" | awk '$3 ~ "^/" && $1 !~ /^lib(c|m)\.so/ { print $3 }' | xargs cp -Lt "$OUT/lib"
for seeds in "$SRC"/hexrelief/tests/fuzz/seeds/*; do
    target=$(basename "$seeds")
    cp "$program" "$OUT/fuzz_$target"
    zip -qj "$OUT/fuzz_${target}_seed_corpus.zip" "$seeds"/*
    printf '[libfuzzer]\nmax_len = 4096\ntimeout = 10\n' >"$OUT/fuzz_$target.options"
done

// A file's bytes, and the one way in which a reader refuses them.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/readers/limits.h"

namespace hexrelief::readers::codec {

struct SourceFile {
    std::filesystem::path path;
    std::vector<std::uint8_t> bytes;  // all; or the first of them, where `file` is open
    std::string key = {};  // which array or channel is wanted where a format holds several; empty = not said
    bool is_map = false;   // of a format that holds a picture and its depths, these are wanted
    ReaderLimits limits = {};
    std::shared_ptr<std::FILE> file = {};       // what is behind the bytes
    std::uint64_t file_size = 0;                // of an open file
    const char* several = "name one by --key";  // what to do where none is named

    std::uint64_t size() const { return file ? file_size : bytes.size(); }
    // Copies what there is of `count` bytes at `offset` in the file, and returns how many those are.
    std::size_t read_at(std::uint64_t offset, void* to, std::size_t count) const;
};

// The first at most `count` bytes. Throws Error(input) where path is missing, no regular file, or not
// readable.
SourceFile load_head(const std::filesystem::path& path, std::size_t count);

// The same with the file open behind them, where it has more.
SourceFile open_file(const std::filesystem::path& path, std::size_t count);

// The whole file. Throws as load_head, and where the file is larger than `max_bytes` (nothing is allocated
// then).
SourceFile load_file(const std::filesystem::path& path, std::uintmax_t max_bytes);

// Throws Error(input): "cannot read 'PATH': REASON".
[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& reason);

// Refuses a zero side and more pixels than the source's limits allow.
void check_size(const SourceFile& source, unsigned long long width, unsigned long long height);

// Refuses a file too short for what its header promises, before anything is allocated for it: a format that
// packs at best `ratio` bytes of samples into one byte of file cannot hold `sample_bytes` in fewer bytes than
// that.
void check_length(const SourceFile& source, unsigned long long sample_bytes, unsigned ratio);

}  // namespace hexrelief::readers::codec

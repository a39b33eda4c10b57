// The bytes of a file, and the one way in which readers refuse it.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/readers/limits.h"

namespace hexrelief::readers::codec {

// What an array or a channel is searched for, if a file holds several.
enum class Wanted { map, confidence, mask };

struct SourceFile {
    std::filesystem::path path;
    std::vector<std::uint8_t> bytes;  // all bytes, or only the first ones if `file` is open
    std::string key = {};  // wanted array or channel, if a format can hold several; empty = not given
    bool is_map = false;   // wanted are depths, if a format can hold both a picture and its depths
    ReaderLimits limits = {};
    std::shared_ptr<std::FILE> file = {};       // gives access to further bytes
    std::uint64_t file_size = 0;                // size of an open file
    const char* several = "name one by --key";  // advice if there are several and none is named
    Wanted wanted = Wanted::map;

    std::uint64_t size() const { return file ? file_size : bytes.size(); }
    // Copies up to `count` bytes at `offset` of the file, and returns how many there were.
    std::size_t read_at(std::uint64_t offset, void* to, std::size_t count) const;
};

// Loads at most the first `count` bytes. Throws Error(input) if the file is missing, not a regular
// file, or not readable.
SourceFile load_head(const std::filesystem::path& path, std::size_t count);

// As load_head(), but keeps the file open if it has more bytes.
SourceFile open_file(const std::filesystem::path& path, std::size_t count);

// Loads the whole file. Throws what load_head() throws, and Error(input) if the file is larger than
// `max_bytes`, or has more than 64 MiB of which less than a thousandth is on the disk; in both cases nothing
// is allocated.
SourceFile load_file(const std::filesystem::path& path, std::uintmax_t max_bytes);

// Throws Error(input): "cannot read 'PATH': REASON".
[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& reason);

// Refuses a zero side, and more pixels than the source's limits allow.
void check_size(const SourceFile& source, unsigned long long width, unsigned long long height);

// Refuses a file that is too short for its header, before anything is allocated: a format that packs at
// best `ratio` bytes of samples into one byte of the file cannot hold `sample_bytes` in fewer bytes
// than sample_bytes / ratio.
void check_length(const SourceFile& source, unsigned long long sample_bytes, unsigned ratio);

}  // namespace hexrelief::readers::codec

// The codecs of raster formats: how each format is recognised, described and decoded.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "pipeline/data/calibration.h"
#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/limits.h"
#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

// Each describe_ function reads only the header; each decode_ function returns the first picture of the file.
// Both throw Error(input) for anything malformed, truncated, empty or larger than the source's limits, and
// never leak or print.
FileDescription describe_png(const SourceFile& source);
Raster decode_png(const SourceFile& source);
FileDescription describe_jpeg(const SourceFile& source);
Raster decode_jpeg(const SourceFile& source);
FileDescription describe_tiff(const SourceFile& source);
Raster decode_tiff(const SourceFile& source);
FileDescription describe_webp(const SourceFile& source);
Raster decode_webp(const SourceFile& source);
FileDescription describe_bmp(const SourceFile& source);
Raster decode_bmp(const SourceFile& source);
FileDescription describe_pnm(const SourceFile& source);
Raster decode_pnm(const SourceFile& source);
FileDescription describe_pfm(const SourceFile& source);
Raster decode_pfm(const SourceFile& source);
// The formats of maps, implemented in pipeline/readers/depth; their describe_ may have to unpack the file.
FileDescription describe_npy(const SourceFile& source);
Raster decode_npy(const SourceFile& source);
// Returns the numbers of an NPY array by rows. Throws Error(input) for sides above 4096, and for types other
// than floats and signed integers.
std::vector<double> read_npy_numbers(const SourceFile& source);
FileDescription describe_npz(const SourceFile& source);
Raster decode_npz(const SourceFile& source);
FileDescription describe_exr(const SourceFile& source);
Raster decode_exr(const SourceFile& source);
std::vector<std::string> list_npz(const SourceFile& source);
std::vector<std::string> list_exr(const SourceFile& source);
// COLMAP's, OpenMVS's and Sintel's depths, and optical flow.
bool is_float_map(std::span<const std::uint8_t> head);
FileDescription describe_float_map(const SourceFile& source);
Raster decode_float_map(const SourceFile& source);
// HEIC: the picture of a photograph, or its depths if SourceFile::is_map.
FileDescription describe_heic(const SourceFile& source);
Raster decode_heic(const SourceFile& source);
struct HeicPictures {
    Raster left, right;
    Calibration camera;  // of the left picture, as in HeicPair
};
// Returns the pictures of a spatial photograph; nullopt if the file has no stereo pair group. The file is
// HEIC.
std::optional<HeicPictures> decode_heic_pair(const SourceFile& source);

enum class Format { png, jpeg, tiff, webp, bmp, pnm, heic, pfm, npy, npz, exr, float_map };

// What a file of a format can give.
enum Gives : unsigned {
    kPicture = 1,
    kBothViews = 2,   // of a pair, which the file tells by itself: two pictures, or halves
    kMap = 4,         // exact samples: of disparities, depths, a mask
    kCamera = 8,      // of its picture, by EXIF data or properties; or a calibration
    kConfidence = 16  // of a map
};

struct Codec {
    Format format;
    const char* name;          // for error messages and FORMATS.md
    std::string_view endings;  // of its files, by which folders are searched
    unsigned gives;            // of Gives
    bool (*recognises)(std::span<const std::uint8_t> head);
    FileDescription (*describe)(const SourceFile& source);
    Raster (*decode)(const SourceFile& source);
    // Returns a line for each array or part: its names, types and sizes; null if there is one alone.
    std::vector<std::string> (*list)(const SourceFile& source) = nullptr;
};

// Returns the codec that recognises the file's first bytes, or null. Throws what load_head() throws.
const Codec* find_codec(const std::filesystem::path& path);

// Returns the codec that recognises the file. Refuses any other file, saying what it seems to be, and that
// `wanted` would be read.
const Codec& require_codec(const std::filesystem::path& path, const std::string& wanted);

// Returns the one table of formats: runs, `info`, batches, help, errors and FORMATS.md, by a test, follow it.
std::span<const Codec> codecs();
// Returns the names of the formats that can give one of these (Gives): "PNG, JPEG, ...".
std::string names_of(unsigned gives);

// The words for a map in error messages: "a disparity map", "disparities".
struct MapWords {
    const char *map, *samples;
    const char* several = "name one by --key";  // as in SourceFile
    Wanted wanted = Wanted::map;
    Packing packing = Packing::none;
};

// Reads the one channel of a map; a colour picture with only grey pixels is accepted as well. `key` names the
// array or channel if the file has several. Throws Error(input) for lossy formats, colour, and floats that
// make sense only in the other byte order.
Raster read_map_raster(const std::filesystem::path& path, const MapWords& words, const std::string& key,
                       const ReaderLimits& limits = {});

// True if most floats are plausible disparities or depths only with their bytes reversed.
bool in_other_order(const std::vector<float>& samples);
// Blames the byte order that a PFM's header states.
[[noreturn]] void refuse_byte_order(const std::filesystem::path& path);

// Loads the whole file, up to the size of any valid raster within the limits.
SourceFile load_raster_file(const std::filesystem::path& path, const ReaderLimits& limits = {});

}  // namespace hexrelief::readers::codec

// The raster formats: how each is recognised, described and decoded.
#pragma once

#include <cstdint>
#include <span>

#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/describe_raster.h"
#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

// Each describe_ reads the header only; each decode_ gives the first picture of the file. Both throw
// Error(input) for anything malformed, truncated, empty or larger than the source's limits, and never leak or
// print on the way.
FileDescription describe_png(const SourceFile& source);
Raster decode_png(const SourceFile& source);
FileDescription describe_jpeg(const SourceFile& source);
Raster decode_jpeg(const SourceFile& source);
FileDescription describe_tiff(const SourceFile& source);
Raster decode_tiff(const SourceFile& source);
FileDescription describe_webp(const SourceFile& source);
Raster decode_webp(const SourceFile& source);
FileDescription describe_pnm(const SourceFile& source);
Raster decode_pnm(const SourceFile& source);
FileDescription describe_pfm(const SourceFile& source);
Raster decode_pfm(const SourceFile& source);
// In pipeline/readers/depth: formats of maps, of which describe_ may have to unpack the file.
FileDescription describe_npy(const SourceFile& source);
Raster decode_npy(const SourceFile& source);
// The numbers of an NPY array of this size, by rows. Throws Error(input) for another size.
std::vector<double> read_npy_numbers(const SourceFile& source, int width, int height);
FileDescription describe_npz(const SourceFile& source);
Raster decode_npz(const SourceFile& source);
FileDescription describe_exr(const SourceFile& source);
Raster decode_exr(const SourceFile& source);
// The picture of a photograph, or the depths beside it (SourceFile::is_map).
FileDescription describe_heic(const SourceFile& source);
Raster decode_heic(const SourceFile& source);

enum class Format { png, jpeg, tiff, webp, pnm, heic, pfm, npy, npz, exr };

struct Codec {
    Format format;
    const char* name;  // for messages
    bool (*recognises)(std::span<const std::uint8_t> head);
    FileDescription (*describe)(const SourceFile& source);
    Raster (*decode)(const SourceFile& source);
};

// The codec whose first bytes those of path are; null where no format is recognised. Throws as load_head.
const Codec* find_codec(const std::filesystem::path& path);

// The same, but refuses a file that has no codec, saying what it seems to be and what would be read.
const Codec& require_codec(const std::filesystem::path& path, const char* wanted);

// What messages call a map: "a disparity map", "disparities".
struct MapWords {
    const char *map, *samples;
    const char* several = "name one by --key";  // as in SourceFile
};

// The one channel of a map, for which a colour picture of grey pixels serves as well. `key` names the array
// or channel where the file has several. Throws Error(input) for formats that keep samples only nearly,
// colour, and floats that only make sense in the other byte order.
Raster read_map_raster(const std::filesystem::path& path, const MapWords& words, const std::string& key,
                       const ReaderLimits& limits = {});

// Whether most floats are disparities or depths only if their bytes are reversed.
bool in_other_order(const std::vector<float>& samples);
[[noreturn]] void refuse_byte_order(const std::filesystem::path& path);  // as a PFM's header states it

// The whole file, as large as any valid raster within the limits may be.
SourceFile load_raster_file(const std::filesystem::path& path, const ReaderLimits& limits = {});

}  // namespace hexrelief::readers::codec

#include "tests/pipeline/readers/depth/sample_maps.h"

#include <zlib.h>

#include <algorithm>

namespace hexrelief::readers {
namespace {

// Appends a number, little endian.
void append(Bytes& bytes, std::uint64_t value, int count) {
    for (int i = 0; i < count; ++i, value >>= 8) bytes.push_back(static_cast<std::uint8_t>(value));
}

void append(Bytes& bytes, const std::string& text) {
    bytes.insert(bytes.end(), text.begin(), text.end());
}

Bytes deflated_bytes(const Bytes& bytes) {
    z_stream stream{};
    deflateInit2(&stream, 6, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
    Bytes packed(deflateBound(&stream, bytes.size()));
    stream.next_in = const_cast<Bytef*>(bytes.data());
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = packed.data();
    stream.avail_out = static_cast<uInt>(packed.size());
    deflate(&stream, Z_FINISH);
    packed.resize(stream.total_out);
    deflateEnd(&stream);
    return packed;
}

void append_attribute(Bytes& bytes, const std::string& name, const std::string& type, const Bytes& value) {
    append(bytes, name + '\0' + type + '\0');
    append(bytes, value.size(), 4);
    bytes = bytes + value;
}

Bytes numbers(const std::vector<int>& values) {
    Bytes bytes;
    for (const int value : values) append(bytes, static_cast<std::uint32_t>(value), 4);
    return bytes;
}

}  // namespace

Bytes make_npy(const std::string& header, const Bytes& samples, int version) {
    Bytes bytes = to_bytes("\x93NUMPY");
    append(bytes, static_cast<unsigned>(version), 2);
    append(bytes, header.size(), version == 1 ? 2 : 4);
    append(bytes, header);
    return bytes + samples;
}

Bytes make_npy(const std::string& type, int width, int height, const Bytes& samples) {
    return make_npy("{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + std::to_string(height) +
                        ", " + std::to_string(width) + "), }\n",
                    samples);
}

Bytes make_zip(const std::vector<std::pair<std::string, Bytes>>& members, bool deflated) {
    Bytes zip, directory;
    for (const auto& [name, bytes] : members) {
        const Bytes packed = deflated ? deflated_bytes(bytes) : bytes;
        Bytes common;  // fields of both headers
        append(common, 20, 2);
        append(common, 0, 2);
        append(common, deflated ? 8 : 0, 2);
        append(common, 0, 4);
        append(common, crc32(0, bytes.data(), static_cast<uInt>(bytes.size())), 4);
        append(common, packed.size(), 4);
        append(common, bytes.size(), 4);
        append(common, name.size(), 2);
        append(common, 0, 2);
        append(directory, 0x02014b50, 4);
        append(directory, 20, 2);
        directory = directory + common;
        append(directory, 0, 10);
        append(directory, zip.size(), 4);
        append(directory, name);
        append(zip, 0x04034b50, 4);
        zip = zip + common;
        append(zip, name);
        zip = zip + packed;
    }
    const std::size_t start = zip.size();
    zip = zip + directory;
    append(zip, 0x06054b50, 4);
    append(zip, 0, 4);
    append(zip, members.size(), 2);
    append(zip, members.size(), 2);
    append(zip, directory.size(), 4);
    append(zip, start, 4);
    append(zip, 0, 2);
    return zip;
}

// Packs one chunk's samples like OpenEXR's ZIP: even bytes before odd ones, as differences.
Bytes exr_zip(const Bytes& plain) {
    Bytes sorted;
    for (const std::size_t first : {0u, 1u})
        for (std::size_t i = first; i < plain.size(); i += 2) sorted.push_back(plain[i]);
    for (std::size_t i = sorted.size(); i-- > 1;)
        sorted[i] = static_cast<std::uint8_t>(sorted[i] - sorted[i - 1] + 128);
    uLongf count = compressBound(sorted.size());
    Bytes packed(count);
    compress(packed.data(), &count, sorted.data(), sorted.size());
    packed.resize(count);
    return packed.size() < plain.size() ? packed : plain;
}

Bytes make_exr(int width, int height, const std::vector<ExrChannel>& channels, const ExrKind& kind) {
    constexpr int left = 3, top = -2;
    Bytes list;
    for (const ExrChannel& channel : channels) {
        append(list, channel.name + '\0');
        list = list + numbers({2, 0, 1, 1});  // float, linear, not subsampled
    }
    list.push_back(0);
    Bytes exr = {0x76, 0x2f, 0x31, 0x01, 2, static_cast<std::uint8_t>(kind.tile > 0 ? 2 : 0), 0, 0};
    const Bytes window = numbers({left, top, left + width - 1, top + height - 1});
    append_attribute(exr, "channels", "chlist", list);
    append_attribute(exr, "compression", "compression", {static_cast<std::uint8_t>(kind.zip ? 2 : 0)});
    append_attribute(exr, "dataWindow", "box2i", window);
    append_attribute(exr, "displayWindow", "box2i", window);
    append_attribute(exr, "lineOrder", "lineOrder", {0});
    append_attribute(exr, "pixelAspectRatio", "float", bytes_of(std::vector<float>{1}));
    append_attribute(exr, "screenWindowCenter", "v2f", bytes_of(std::vector<float>{0, 0}));
    append_attribute(exr, "screenWindowWidth", "float", bytes_of(std::vector<float>{1}));
    if (kind.tile > 0) append_attribute(exr, "tiles", "tiledesc", numbers({kind.tile, kind.tile}) + Bytes{0});
    exr.push_back(0);
    std::vector<Bytes> chunks;
    const int chunk_width = kind.tile > 0 ? kind.tile : width, chunk_height = kind.tile > 0 ? kind.tile : 1;
    for (int y = 0; y < height; y += chunk_height)
        for (int x = 0; x < width; x += chunk_width) {
            Bytes plain;
            for (int row = y; row < std::min(y + chunk_height, height); ++row)
                for (const ExrChannel& channel : channels) {
                    const float* const from = channel.samples.data() + static_cast<std::size_t>(row) * width;
                    plain = plain +
                            bytes_of(std::vector<float>(from + x, from + std::min(x + chunk_width, width)));
                }
            const Bytes packed = kind.zip ? exr_zip(plain) : plain;
            const auto size = static_cast<int>(packed.size());
            chunks.push_back((kind.tile > 0 ? numbers({x / kind.tile, y / kind.tile, 0, 0, size})
                                            : numbers({top + y, size})) +
                             packed);
        }
    std::size_t at = exr.size() + chunks.size() * 8;
    for (const Bytes& chunk : chunks) {
        append(exr, at, 8);
        at += chunk.size();
    }
    for (const Bytes& chunk : chunks) exr = exr + chunk;
    return exr;
}

}  // namespace hexrelief::readers

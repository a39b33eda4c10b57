// Reads portable float maps. Only the sign of the header's scale is used, negative meaning little endian:
// Middlebury writes 1/255 there, and a reader that multiplies by it is wrong by a factor of 255.
#include <bit>
#include <cstring>

#include "pipeline/readers/codecs.h"
#include "pipeline/readers/netpbm_header.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

// Refuses more than a final line end after the last sample: header and samples then do not belong together.
void check_end(const SourceFile& source, std::size_t end) {
    for (std::size_t i = end; i < source.bytes.size(); ++i) {
        if (i - end >= 2 || (source.bytes[i] != '\n' && source.bytes[i] != '\r')) {
            refuse(source.path,
                   std::to_string(source.bytes.size() - end) +
                       " bytes follow the last sample, so the header's size is wrong; export it again");
        }
    }
}

}  // namespace

PfmHeader read_pfm_header(const SourceFile& source, NetpbmHeader& header) {
    PfmHeader pfm{};
    pfm.channels = source.bytes.at(1) == 'F' ? 3 : 1;
    pfm.width = header.next_number("width");
    pfm.height = header.next_number("height");
    const std::string_view word = header.next_word();
    const auto scale = parse_number(word);
    if (!scale || *scale == 0) {
        refuse(source.path,
               "its header has " + excerpt(word) +
                   " as scale; its sign tells the byte order, so it must be a number other than 0");
    }
    pfm.little_endian = *scale < 0;
    return pfm;
}

FileDescription describe_pfm(const SourceFile& source) {
    NetpbmHeader header(source);
    const PfmHeader pfm = read_pfm_header(source, header);
    check_size(source, pfm.width, pfm.height);
    return {"pfm", static_cast<int>(pfm.width), static_cast<int>(pfm.height), pfm.channels, 32, true};
}

Raster decode_pfm(const SourceFile& source) {
    NetpbmHeader header(source);
    const PfmHeader pfm = read_pfm_header(source, header);
    check_size(source, pfm.width, pfm.height);
    const std::size_t row_samples = static_cast<std::size_t>(pfm.width) * pfm.channels;
    const std::size_t row_bytes = row_samples * sizeof(float);
    const std::size_t start = header.samples_at(static_cast<unsigned long long>(row_bytes) * pfm.height);
    check_end(source, start + row_bytes * pfm.height);

    std::vector<float> samples(row_samples * pfm.height);
    const bool swap = pfm.little_endian != (std::endian::native == std::endian::little);
    for (std::size_t y = 0; y < pfm.height; ++y) {
        float* row = samples.data() + y * row_samples;
        std::memcpy(row, source.bytes.data() + start + (pfm.height - 1 - y) * row_bytes, row_bytes);
        for (std::size_t i = 0; swap && i < row_samples; ++i) {
            row[i] = in_other_byte_order(row[i]);
        }
    }
    return {static_cast<int>(pfm.width), static_cast<int>(pfm.height), pfm.channels, 0, kNoData,
            std::move(samples)};
}

}  // namespace hexrelief::readers::codec

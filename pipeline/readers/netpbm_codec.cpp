#include "pipeline/readers/netpbm_codec.h"

#include <bit>
#include <cstring>

#include "pipeline/data/number_text.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

// Refuses more than a final line end after the last sample: header and samples then do not belong together.
void check_end(const SourceFile& source, std::size_t end) {
    for (std::size_t i = end; i < source.bytes.size(); ++i)
        if (i - end >= 2 || (source.bytes[i] != '\n' && source.bytes[i] != '\r'))
            refuse(source.path,
                   std::to_string(source.bytes.size() - end) +
                       " bytes follow the last sample, so the header's size is wrong; export it again");
}

}  // namespace

std::string_view NetpbmHeader::next_word() {
    const auto& bytes = source_.bytes;
    while (at_ < bytes.size() && (is_space(bytes[at_]) || bytes[at_] == '#')) {
        if (bytes[at_] == '#')
            while (at_ < bytes.size() && bytes[at_] != '\n' && bytes[at_] != '\r') ++at_;
        else
            ++at_;
    }
    const std::size_t start = at_;
    while (at_ < bytes.size() && !is_space(bytes[at_]) && bytes[at_] != '#') ++at_;
    return {reinterpret_cast<const char*>(bytes.data()) + start, at_ - start};
}

unsigned NetpbmHeader::next_number(const char* what) {
    const std::string_view word = next_word();
    const auto value = whole_number(word);
    if (word.size() > 9 || !value)
        refuse(source_.path, std::string("its header has ") + excerpt(word) + " as " + what +
                                 " instead of a whole number; export it again");
    return static_cast<unsigned>(*value);
}

std::size_t NetpbmHeader::samples_at(unsigned long long sample_bytes, unsigned long long file_bytes) const {
    const auto& bytes = source_.bytes;
    if (at_ >= bytes.size() || !is_space(bytes[at_]))
        refuse(source_.path, "its header ends without white space before the samples; export it again");
    const unsigned long long left = file_bytes - at_ - 1;
    if (left < sample_bytes)
        refuse(source_.path, "truncated: the header promises " + std::to_string(sample_bytes) +
                                 " bytes of samples, " + std::to_string(left) +
                                 " are there; copy or export it again");
    const bool windows =
        bytes[at_] == '\r' && left == sample_bytes + 1 && at_ + 1 < bytes.size() && bytes[at_ + 1] == '\n';
    return at_ + (windows ? 2 : 1);
}

PnmHeader read_pnm_header(const SourceFile& source, NetpbmHeader& header) {
    PnmHeader pnm{};
    pnm.channels = source.bytes.at(1) == '6' ? 3 : 1;
    pnm.width = header.next_number("width");
    pnm.height = header.next_number("height");
    pnm.max_value = header.next_number("maxval");
    if (pnm.max_value < 1 || pnm.max_value > 65535)
        refuse(source.path, "its maxval is " + std::to_string(pnm.max_value) +
                                "; it must lie in 1..65535, export it again");
    return pnm;
}

FileDescription describe_pnm(const SourceFile& source) {
    NetpbmHeader header(source);
    const PnmHeader pnm = read_pnm_header(source, header);
    check_size(source, pnm.width, pnm.height);
    return {pnm.channels == 3 ? "ppm" : "pgm", static_cast<int>(pnm.width), static_cast<int>(pnm.height),
            pnm.channels, pnm.max_value > 255 ? 16 : 8};
}

Raster decode_pnm(const SourceFile& source) {
    NetpbmHeader header(source);
    const PnmHeader pnm = read_pnm_header(source, header);
    check_size(source, pnm.width, pnm.height);
    const bool wide = pnm.max_value > 255;
    const std::size_t count = static_cast<std::size_t>(pnm.width) * pnm.height * pnm.channels;
    const std::uint8_t* from = source.bytes.data() + header.samples_at(count * (wide ? 2 : 1));

    Raster raster{.width = static_cast<int>(pnm.width),
                  .height = static_cast<int>(pnm.height),
                  .channels = pnm.channels,
                  .max_value = pnm.max_value};
    if (wide) {
        std::vector<std::uint16_t> samples(count);
        for (std::size_t i = 0; i < count; ++i)
            samples[i] = static_cast<std::uint16_t>(from[2 * i] << 8 | from[2 * i + 1]);
        raster.samples = std::move(samples);
    } else {
        raster.samples = std::vector<std::uint8_t>(from, from + count);
    }
    return raster;
}

PfmHeader read_pfm_header(const SourceFile& source, NetpbmHeader& header) {
    PfmHeader pfm{};
    pfm.channels = source.bytes.at(1) == 'F' ? 3 : 1;
    pfm.width = header.next_number("width");
    pfm.height = header.next_number("height");
    const std::string_view word = header.next_word();
    const auto scale = parse_number(word);
    if (!scale || *scale == 0)
        refuse(source.path,
               "its header has " + excerpt(word) +
                   " as scale; its sign tells the byte order, so it must be a number other than 0");
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
        for (std::size_t i = 0; swap && i < row_samples; ++i) row[i] = in_other_byte_order(row[i]);
    }
    return {static_cast<int>(pfm.width), static_cast<int>(pfm.height), pfm.channels, 0, kNoData,
            std::move(samples)};
}

}  // namespace hexrelief::readers::codec

// The plain-text header that PGM, PPM and PFM share.
#pragma once

#include <string_view>

#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

// Walks over a header's words: white space and comments (# to the end of the line) between them are skipped.
class NetpbmHeader {
  public:
    // Starts after the two letters of the kind.
    explicit NetpbmHeader(const SourceFile& source) : source_(source) {}

    std::string_view next_word();
    // A decimal number of at most 9 digits; refuses anything else, naming `what`.
    unsigned next_number(const char* what);
    // Where the samples start: after the one white-space byte that ends the header. A CR LF pair counts as
    // one where the file then has exactly `sample_bytes` left. Refuses a file with fewer bytes than that, of
    // which the source may hold the first ones only.
    std::size_t samples_at(unsigned long long sample_bytes, unsigned long long file_bytes) const;
    std::size_t samples_at(unsigned long long sample_bytes) const {
        return samples_at(sample_bytes, source_.bytes.size());
    }

  private:
    const SourceFile& source_;
    std::size_t at_ = 2;
};

struct PfmHeader {
    unsigned width, height;  // as they stand there, be it 0
    int channels;
    bool little_endian;
};

struct PnmHeader {
    unsigned width, height;  // as they stand there, be it 0
    unsigned max_value;      // 1..65535; above 255 a sample has two bytes, the higher one first
    int channels;            // 1 = PGM, 3 = PPM
};

// Leave `header`, which stands at the file's start, where the samples begin.
PfmHeader read_pfm_header(const SourceFile& source, NetpbmHeader& header);
PnmHeader read_pnm_header(const SourceFile& source, NetpbmHeader& header);

}  // namespace hexrelief::readers::codec

// Parses the plain-text header that PGM, PPM and PFM share.
#pragma once

#include <string_view>

#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

// Walks over a header's words, skipping white space and comments (# to the end of the line) between them.
class NetpbmHeader {
  public:
    // Starts after the two letters of the file's kind.
    explicit NetpbmHeader(const SourceFile& source) : source_(source) {}

    std::string_view next_word();
    // Returns a decimal number of at most 9 digits; refuses anything else, naming `what`.
    unsigned next_number(const char* what);
    // Returns the offset of the samples: after the one white-space byte that ends the header. A CR LF pair
    // counts as one if the file then has exactly `sample_bytes` left. Refuses a file with fewer bytes than
    // that. `file_bytes` is the size of the file, of which the source may hold only the first bytes.
    std::size_t samples_at(unsigned long long sample_bytes, unsigned long long file_bytes) const;
    std::size_t samples_at(unsigned long long sample_bytes) const {
        return samples_at(sample_bytes, source_.bytes.size());
    }

  private:
    const SourceFile& source_;
    std::size_t at_ = 2;
};

struct PfmHeader {
    unsigned width, height;  // as stored, may be 0
    int channels;
    bool little_endian;
};

struct PnmHeader {
    unsigned width, height;  // as stored, may be 0
    unsigned max_value;      // 1..65535; if above 255, a sample has two bytes, the higher one first
    int channels;            // 1 = PGM, 3 = PPM
};

// Parse the file's header. `header` must be at the file's start; afterwards it is at the end of the header.
PfmHeader read_pfm_header(const SourceFile& source, NetpbmHeader& header);
PnmHeader read_pnm_header(const SourceFile& source, NetpbmHeader& header);

}  // namespace hexrelief::readers::codec

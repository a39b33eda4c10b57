// libjpeg's errors, which leave by longjmp, and its output in memory.
#pragma once

#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <vector>
// libjpeg's header needs stdio first.
#include <jpeglib.h>

namespace hexrelief::exporters {

// Every call of libjpeg that can fail runs in a function whose frame holds nothing with a destructor, after
// setjmp(jump).
struct JpegErrors {
    jpeg_error_mgr manager;  // first, so that a pointer to it is also a pointer to JpegErrors
    std::jmp_buf jump;
    char message[JMSG_LENGTH_MAX];
};

// Sets an object's error handling; errors must outlive it.
jpeg_error_mgr* catch_errors(JpegErrors& errors);

// Where libjpeg writes. Its own destination in memory leaves a freed buffer behind if memory ends.
struct JpegSink {
    jpeg_destination_mgr manager;  // first, so that a pointer to it is also a pointer to JpegSink
    std::vector<std::uint8_t> bytes = std::vector<std::uint8_t>(1 << 16);

    JpegSink();

    void offer_from(std::size_t written) {
        manager.next_output_byte = bytes.data() + written;
        manager.free_in_buffer = bytes.size() - written;
    }
};

}  // namespace hexrelief::exporters

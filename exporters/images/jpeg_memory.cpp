#include "exporters/images/jpeg_memory.h"

// After jpeglib.h.
#include <jerror.h>

#include <new>

namespace hexrelief::exporters {
namespace {

[[noreturn]] void jpeg_failed(j_common_ptr common) {
    auto* errors = reinterpret_cast<JpegErrors*>(common->err);
    common->err->format_message(common, errors->message);
    std::longjmp(errors->jump, 1);
}

void jpeg_said(j_common_ptr) {}

JpegSink& sink_of(j_compress_ptr jpeg) {
    return *reinterpret_cast<JpegSink*>(jpeg->dest);
}

void jpeg_begins(j_compress_ptr jpeg) {
    sink_of(jpeg).offer_from(0);
}

boolean jpeg_is_full(j_compress_ptr jpeg) {
    JpegSink& sink = sink_of(jpeg);
    const std::size_t written = sink.bytes.size();
    bool is_grown = true;
    try {
        sink.bytes.resize(2 * written);
    } catch (const std::bad_alloc&) {
        is_grown = false;  // no jump out of a handler
    }
    if (!is_grown) ERREXIT1(jpeg, JERR_OUT_OF_MEMORY, 0);
    sink.offer_from(written);
    return TRUE;
}

void jpeg_ends(j_compress_ptr jpeg) {
    JpegSink& sink = sink_of(jpeg);
    sink.bytes.resize(sink.bytes.size() - sink.manager.free_in_buffer);
}

}  // namespace

jpeg_error_mgr* catch_errors(JpegErrors& errors) {
    jpeg_std_error(&errors.manager);
    errors.manager.error_exit = jpeg_failed;
    errors.manager.output_message = jpeg_said;
    return &errors.manager;
}

JpegSink::JpegSink() : manager{nullptr, 0, jpeg_begins, jpeg_is_full, jpeg_ends} {}

}  // namespace hexrelief::exporters

#include "exporters/viewer/viewer_page.h"

#ifdef HEXRELIEF_VIEWER_PAGE
// The assembler reads the file; as an array in C++ it would take the compiler a gigabyte.
asm(".pushsection .rodata\n"
    ".hidden hexrelief_viewer_page, hexrelief_viewer_page_end\n"
    ".global hexrelief_viewer_page, hexrelief_viewer_page_end\n"
    "hexrelief_viewer_page: .incbin \"" HEXRELIEF_VIEWER_PAGE
    "\"\n"
    "hexrelief_viewer_page_end: .byte 0\n"
    ".popsection\n");
extern "C" const char hexrelief_viewer_page[], hexrelief_viewer_page_end[];
#endif

namespace hexrelief {

std::string_view viewer_page() {
#ifdef HEXRELIEF_VIEWER_PAGE
    return {hexrelief_viewer_page,
            static_cast<std::size_t>(hexrelief_viewer_page_end - hexrelief_viewer_page)};
#else
    return {};
#endif
}

}  // namespace hexrelief

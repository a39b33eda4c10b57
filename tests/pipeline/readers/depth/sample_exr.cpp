// Makes EXR files of several parts by OpenEXR itself.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>

#include "tests/pipeline/readers/depth/sample_maps.h"

namespace hexrelief::readers {

Bytes make_exr_parts(const std::vector<ExrPart>& parts) {
    std::vector<Imf::Header> headers;
    for (const ExrPart& part : parts) {
        const auto& data = part.data;
        Imf::Header header(
            Imath::Box2i({part.display[0], part.display[1]}, {part.display[2], part.display[3]}),
            Imath::Box2i({data[0], data[1]}, {data[2], data[3]}));
        header.setName(part.name);
        header.setType(Imf::SCANLINEIMAGE);
        header.compression() = part.lossy ? Imf::DWAA_COMPRESSION : Imf::ZIP_COMPRESSION;
        for (const ExrChannel& channel : part.channels)
            header.channels().insert(channel.name, Imf::Channel(part.half ? Imf::HALF : Imf::FLOAT));
        headers.push_back(header);
    }
    const Folder folder;
    const std::filesystem::path path = folder.path() / "parts.exr";
    {
        Imf::MultiPartOutputFile file(path.c_str(), headers.data(), static_cast<int>(headers.size()));
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const Imath::Box2i window = headers[i].dataWindow();
            std::vector<std::vector<half>> halves;
            Imf::FrameBuffer frame;
            for (const ExrChannel& channel : parts[i].channels) {
                halves.emplace_back(channel.samples.begin(), channel.samples.end());
                const void* const first =
                    parts[i].half ? static_cast<const void*>(halves.back().data()) : channel.samples.data();
                const std::size_t bytes = parts[i].half ? sizeof(half) : sizeof(float);
                frame.insert(channel.name,
                             Imf::Slice::Make(parts[i].half ? Imf::HALF : Imf::FLOAT, first, window, bytes));
            }
            Imf::OutputPart out(file, static_cast<int>(i));
            out.setFrameBuffer(frame);
            out.writePixels(window.max.y - window.min.y + 1);
        }
    }
    return read_bytes(path);
}

}  // namespace hexrelief::readers

// Copies between pageable host memory and the device through a few pinned buffers.
#pragma once

#include <cuda_runtime_api.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <deque>
#include <initializer_list>

#include "cuda/common/check.h"

namespace hexrelief::cuda {

// Pinning an image itself takes longer than copying it once; so the host fills one buffer while the device
// reads another. The buffers are allocated at the first use and live as long as the object.
class Staging {
  public:
    Staging() = default;
    Staging(const Staging&) = delete;
    Staging& operator=(const Staging&) = delete;
    ~Staging() {
        for (Buffer& buffer : buffers_) {
            if (buffer.data) cudaFreeHost(buffer.data);
            if (buffer.free) cudaEventDestroy(buffer.free);
        }
    }

    // Uploads an array. Returns when `from` may be changed; the copy to the device is ordered in the stream.
    template <typename T>
    void upload(cudaStream_t stream, T* to, const T* from, std::size_t count) {
        for (std::size_t done = 0; done < count;) {
            const std::size_t part = std::min(count - done, kBytes / sizeof(T));
            Buffer& buffer = next();
            std::memcpy(buffer.data, from + done, part * sizeof(T));
            check(cudaMemcpyAsync(to + done, buffer.data, part * sizeof(T), cudaMemcpyHostToDevice, stream),
                  "uploading");
            check(cudaEventRecord(buffer.free, stream), "uploading");
            done += part;
        }
    }
    // Uploads bytes behind `zeros` bytes of 0, in one transfer if they fit a buffer; `to` is the
    // start of the zeros.
    void upload_behind_zeros(cudaStream_t stream, void* to, std::size_t zeros, const void* from,
                             std::size_t bytes) {
        char* const behind = static_cast<char*>(to) + zeros;
        if (zeros + bytes > kBytes) {
            check(cudaMemsetAsync(to, 0, zeros, stream), "clearing");
            upload(stream, behind, static_cast<const char*>(from), bytes);
            return;
        }
        Buffer& buffer = next();
        std::memset(buffer.data, 0, zeros);
        std::memcpy(static_cast<char*>(buffer.data) + zeros, from, bytes);
        check(cudaMemcpyAsync(to, buffer.data, zeros + bytes, cudaMemcpyHostToDevice, stream), "uploading");
        check(cudaEventRecord(buffer.free, stream), "uploading");
    }
    // Uploads rows of `width` items that begin `stride` items apart, and packs them on the device. A row may
    // have at most kBytes bytes.
    template <typename T>
    void upload_rows(cudaStream_t stream, T* to, const T* from, std::size_t width, std::size_t rows,
                     std::size_t stride) {
        const std::size_t most = kBytes / (width * sizeof(T));
        for (std::size_t done = 0; done < rows;) {
            const std::size_t part = std::min(rows - done, most);
            Buffer& buffer = next();
            for (std::size_t row = 0; row < part; ++row)
                std::memcpy(static_cast<T*>(buffer.data) + row * width, from + (done + row) * stride,
                            width * sizeof(T));
            check(cudaMemcpyAsync(to + done * width, buffer.data, part * width * sizeof(T),
                                  cudaMemcpyHostToDevice, stream),
                  "uploading");
            check(cudaEventRecord(buffer.free, stream), "uploading");
            done += part;
        }
    }
    // Downloads an array. Returns when `to` is filled.
    template <typename T>
    void download(cudaStream_t stream, T* to, const T* from, std::size_t count) {
        download_all(stream, {{to, from, count * sizeof(T)}});
    }
    // Downloads bytes into a pinned buffer, valid until the next call of any member; returns null if they do
    // not fit a buffer.
    const char* download_in_place(cudaStream_t stream, const void* from, std::size_t bytes) {
        if (bytes > kBytes) return nullptr;
        Buffer& buffer = next();
        check(cudaMemcpyAsync(buffer.data, from, bytes, cudaMemcpyDeviceToHost, stream), "downloading");
        check(cudaEventRecord(buffer.free, stream), "downloading");
        check(cudaEventSynchronize(buffer.free), "downloading");
        return static_cast<const char*>(buffer.data);
    }
    struct Copy {
        void* to;
        const void* from;
        std::size_t bytes;
    };
    // Downloads several arrays: the device fills buffers while the host empties the preceding ones.
    void download_all(cudaStream_t stream, std::initializer_list<Copy> copies) {
        std::deque<Part> parts;
        for (const Copy& copy : copies)
            for (std::size_t done = 0; done < copy.bytes; done += kBytes) {
                if (parts.size() == kBuffers) finish(parts);
                Buffer& buffer = next();
                const std::size_t bytes = std::min(copy.bytes - done, kBytes);
                check(cudaMemcpyAsync(buffer.data, static_cast<const char*>(copy.from) + done, bytes,
                                      cudaMemcpyDeviceToHost, stream),
                      "downloading");
                check(cudaEventRecord(buffer.free, stream), "downloading");
                parts.push_back({&buffer, static_cast<char*>(copy.to) + done, bytes});
            }
        while (!parts.empty()) finish(parts);
    }

  private:
    struct Buffer {
        void* data = nullptr;
        cudaEvent_t free = nullptr;
    };
    struct Part {
        Buffer* buffer;
        char* to;
        std::size_t bytes;
    };
    static constexpr std::size_t kBytes = std::size_t{512} << 10;
    static constexpr std::size_t kBuffers = 4;

    static void finish(std::deque<Part>& parts) {
        const Part part = parts.front();
        parts.pop_front();
        check(cudaEventSynchronize(part.buffer->free), "downloading");
        std::memcpy(part.to, part.buffer->data, part.bytes);
    }

    Buffer& next() {
        Buffer& buffer = buffers_[next_buffer_++ % kBuffers];
        if (!buffer.data) {
            check(cudaHostAlloc(&buffer.data, kBytes, cudaHostAllocDefault), "allocating pinned memory");
            check(cudaEventCreateWithFlags(&buffer.free, cudaEventDisableTiming), "creating an event");
        } else {
            check(cudaEventSynchronize(buffer.free), "waiting for a copy");
        }
        return buffer;
    }

    Buffer buffers_[kBuffers];
    unsigned next_buffer_ = 0;
};

}  // namespace hexrelief::cuda

#include "pipeline/tiles/tile_files.h"

#include <bit>
#include <cstdint>
#include <fstream>
#include <string>

#include "pipeline/data/error.h"

namespace hexrelief::tiles {
namespace {

static_assert(std::endian::native == std::endian::little);
static_assert(sizeof(mesh_tiles::Place) == 8 && sizeof(mesh_tiles::TileCorner) == 12 &&
              sizeof(Triangle) == 12);

enum class Kind : std::uint32_t { lattice = 1, seam = 2, tile = 3 };
constexpr std::uint32_t kMagic = 0x31545848;  // "HXT1"

class Writer {
  public:
    explicit Writer(Kind kind) {
        put(kMagic);
        put(kind);
    }
    template <typename T>
    void put(const T& value) {
        append(&value, sizeof value);
    }
    // Puts the number of values, then the values.
    template <typename T>
    void put_all(const std::vector<T>& values) {
        put(static_cast<std::uint64_t>(values.size()));
        append(values.data(), values.size() * sizeof(T));
    }
    std::vector<std::uint8_t> take() { return std::move(bytes_); }

  private:
    void append(const void* data, std::size_t size) {
        const auto* const first = static_cast<const std::uint8_t*>(data);
        bytes_.insert(bytes_.end(), first, first + size);
    }
    std::vector<std::uint8_t> bytes_;
};

class Reader {
  public:
    Reader(const std::filesystem::path& path, Kind kind) : path_(path), file_(path, std::ios::binary) {
        if (!file_) refuse("cannot be read");
        file_.seekg(0, std::ios::end);
        left_ = static_cast<std::uint64_t>(std::max<std::streamoff>(0, file_.tellg()));
        file_.seekg(0);
        if (get<std::uint32_t>() != kMagic || get<Kind>() != kind) refuse("is no such file of a plan");
    }
    template <typename T>
    T get() {
        T value{};
        copy(&value, sizeof value);
        return value;
    }
    template <typename T>
    std::vector<T> get_all() {
        const auto count = get<std::uint64_t>();
        if (count > left_ / sizeof(T)) refuse("is truncated");
        std::vector<T> values(count);
        copy(values.data(), count * sizeof(T));
        return values;
    }
    void end() const {
        if (left_ != 0) refuse("is damaged");
    }
    [[noreturn]] void refuse(const std::string& why) const {
        throw Error(ErrorKind::input,
                    path_.string() + ": " + why + "; remove it and run the command that writes it again");
    }

  private:
    void copy(void* to, std::uint64_t size) {
        if (size > left_) refuse("is truncated");
        file_.read(static_cast<char*>(to), static_cast<std::streamsize>(size));
        if (!file_) refuse("cannot be read");
        left_ -= size;
    }
    std::filesystem::path path_;
    std::ifstream file_;
    std::uint64_t left_ = 0;
};

bool fits(int columns, int rows, std::size_t count) {
    return columns >= 0 && rows >= 0 && static_cast<std::uint64_t>(columns) * rows == count;
}

}  // namespace

std::vector<std::uint8_t> lattice_bytes(const HexMesh2D& lattice) {
    Writer writer(Kind::lattice);
    writer.put(lattice.columns);
    writer.put(lattice.rows);
    writer.put_all(lattice.positions);
    return writer.take();
}

HexMesh2D read_lattice(const std::filesystem::path& path) {
    Reader reader(path, Kind::lattice);
    HexMesh2D lattice{
        .columns = reader.get<int>(), .rows = reader.get<int>(), .positions = reader.get_all<Vec2f>()};
    reader.end();
    if (!fits(lattice.columns, lattice.rows, lattice.positions.size())) reader.refuse("is damaged");
    return lattice;
}

std::vector<std::uint8_t> seam_bytes(const mesh_tiles::Seam& seam) {
    Writer writer(Kind::seam);
    for (const int value :
         {seam.first_column, seam.first_row, seam.end_column, seam.end_row, seam.block.first_column,
          seam.block.first_row, seam.block.columns, seam.block.rows})
        writer.put(value);
    writer.put_all(seam.block.places);
    return writer.take();
}

mesh_tiles::Seam read_seam(const std::filesystem::path& path) {
    Reader reader(path, Kind::seam);
    mesh_tiles::Seam seam;
    for (int* const value :
         {&seam.first_column, &seam.first_row, &seam.end_column, &seam.end_row, &seam.block.first_column,
          &seam.block.first_row, &seam.block.columns, &seam.block.rows})
        *value = reader.get<int>();
    seam.block.places = reader.get_all<mesh_tiles::Place>();
    reader.end();
    if (!fits(seam.block.columns, seam.block.rows, seam.block.places.size())) reader.refuse("is damaged");
    return seam;
}

std::vector<std::uint8_t> tile_bytes(const mesh_tiles::TileMesh& mesh) {
    Writer writer(Kind::tile);
    writer.put_all(mesh.corners);
    writer.put_all(mesh.triangles);
    writer.put_all(mesh.seam_edges);
    return writer.take();
}

mesh_tiles::TileMesh read_tile(const std::filesystem::path& path) {
    Reader reader(path, Kind::tile);
    mesh_tiles::TileMesh mesh{.corners = reader.get_all<mesh_tiles::TileCorner>(),
                              .triangles = reader.get_all<Triangle>(),
                              .seam_edges = reader.get_all<std::array<mesh_tiles::TileCorner, 2>>()};
    reader.end();
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t corner : t)
            if (corner >= mesh.corners.size()) reader.refuse("is damaged");
    return mesh;
}

}  // namespace hexrelief::tiles

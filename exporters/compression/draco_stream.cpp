#include "exporters/compression/draco_stream.h"

#include <draco/attributes/attribute_quantization_transform.h>
#include <draco/compression/expert_encode.h>
#include <draco/compression/mesh/mesh_edgebreaker_encoder.h>
#include <draco/core/quantization_utils.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <future>
#include <memory>
#include <string>

#include "pipeline/data/background.h"
#include "pipeline/data/error.h"

namespace hexrelief {
namespace {

using draco::GeometryAttribute;
using Bytes = std::vector<std::uint8_t>;

[[noreturn]] void refuse(const std::string& reason) {
    throw Error(ErrorKind::output, "cannot compress the mesh with Draco: " + reason);
}

// Draco's Edgebreaker, which notes where the bytes of each attribute lie. They say nothing about the other
// attributes' bytes, so that those of one can be exchanged for others that decode to the same values.
class SplittingEncoder : public draco::MeshEdgebreakerEncoder {
  public:
    SplittingEncoder(const draco::Mesh& mesh, const draco::EncoderOptions& options) {
        SetMesh(mesh);
        const draco::Status status = Encode(options, &stream_);
        if (!status.ok()) refuse(status.error_msg_string());
    }
    Bytes bytes() const { return {stream_.data(), stream_.data() + stream_.size()}; }
    // What stands before all attributes.
    Bytes head() const { return {stream_.data(), stream_.data() + ends_.front()}; }
    // Of attribute i. Precondition: a speed below 6, at which each attribute has an encoder of its own.
    Bytes attribute(std::size_t i) const {
        return {stream_.data() + ends_[i], stream_.data() + ends_[i + 1]};
    }

  protected:
    // As the base does it for attributes that depend on none that stands behind them.
    bool EncodeAllAttributes() override {
        ends_ = {buffer()->size()};
        for (int i = 0; i < num_attributes_encoders(); ++i) {
            if (!attributes_encoder(i)->EncodeAttributes(buffer())) return false;
            ends_.push_back(buffer()->size());
        }
        return true;
    }

  private:
    draco::EncoderBuffer stream_;
    std::vector<std::size_t> ends_;
};

// The origin and the range by which Draco makes floats of a grid's cells and cells of floats.
struct DracoBox {
    int bits;
    std::array<float, 3> origin = {};
    float range;
};

template <int N>
DracoBox box_of(const Grid<N>& grid) {
    DracoBox box{grid.bits(), {}, 0};
    std::copy(grid.origin.begin(), grid.origin.end(), box.origin.begin());
    box.range = static_cast<float>(grid.step[0] * ((1u << box.bits) - 1));
    return box;
}

void quantise(draco::ExpertEncoder& options, int attribute, GeometryAttribute::Type type,
              const DracoQuantisation& quantisation) {
    const auto set = [&](int bits, const auto& grid, int components) {
        if (!grid) {
            options.SetAttributeQuantization(attribute, bits);
            return;
        }
        const DracoBox box = box_of(*grid);
        options.SetAttributeExplicitQuantization(attribute, box.bits, components, box.origin.data(),
                                                 box.range);
    };
    if (type == GeometryAttribute::POSITION)
        set(quantisation.position_bits, quantisation.positions, 3);
    else if (type == GeometryAttribute::NORMAL)
        options.SetAttributeQuantization(attribute, quantisation.normal_bits);
    else
        set(quantisation.texcoord_bits, quantisation.texcoords, 2);
}

struct Trial {
    GeometryAttribute::Type type;
    int prediction;
};

// The predictions that Draco would not choose: they save up to 13 % where surfaces are planes (venus),
// nothing on others.
constexpr Trial kTrials[] = {
    {GeometryAttribute::NORMAL, draco::PREDICTION_DIFFERENCE},
    {GeometryAttribute::TEX_COORD, draco::MESH_PREDICTION_PARALLELOGRAM},
    {GeometryAttribute::TEX_COORD, draco::MESH_PREDICTION_CONSTRAINED_MULTI_PARALLELOGRAM}};

struct TriedAttribute {
    GeometryAttribute::Type type;
    Bytes bytes;
};

// All trials in one stream: a mesh with the same triangles, positions that cost next to nothing, because no
// trial predicts by them, and for each trial a copy of its attribute.
std::vector<TriedAttribute> try_predictions(const draco::Mesh& input, const DracoQuantisation& quantisation) {
    draco::Mesh mesh;
    mesh.set_num_points(input.num_points());
    mesh.SetNumFaces(input.num_faces());
    for (draco::FaceIndex face(0); face < input.num_faces(); ++face) mesh.SetFace(face, input.face(face));
    GeometryAttribute position;
    position.Init(GeometryAttribute::POSITION, nullptr, 1, draco::DT_UINT8, false, 1, 0);
    mesh.AddAttribute(position, true, input.num_points());
    const Bytes zeros(input.num_points());
    mesh.attribute(0)->buffer()->Write(0, zeros.data(), zeros.size());
    draco::ExpertEncoder options(mesh);
    options.SetSpeedOptions(10 - quantisation.level, 10 - quantisation.level);
    options.SetAttributePredictionScheme(0, draco::PREDICTION_DIFFERENCE);
    std::vector<TriedAttribute> tried;
    for (const auto& [type, prediction] : kTrials) {
        const draco::PointAttribute* const values = input.GetNamedAttribute(type);
        if (!values) continue;
        auto copy = std::make_unique<draco::PointAttribute>();
        copy->CopyFrom(*values);
        const int index = mesh.AddAttribute(std::move(copy));
        quantise(options, index, type, quantisation);
        options.SetAttributePredictionScheme(index, prediction);
        tried.push_back({type, {}});
    }
    const SplittingEncoder encoder(mesh, options.options());
    for (std::size_t i = 0; i < tried.size(); ++i) tried[i].bytes = encoder.attribute(i + 1);
    return tried;
}

// The stream with the bytes of each attribute exchanged for the shortest that decode to the same.
Bytes with_shortest(const draco::Mesh& mesh, const SplittingEncoder& encoder,
                    const std::vector<TriedAttribute>& tried) {
    Bytes stream = encoder.head();
    for (int i = 0; i < mesh.num_attributes(); ++i) {
        Bytes best = encoder.attribute(i);
        for (const auto& [type, bytes] : tried)
            if (type == mesh.attribute(i)->attribute_type() && bytes.size() < best.size()) best = bytes;
        stream.insert(stream.end(), best.begin(), best.end());
    }
    return stream;
}

// Bounds of the positions that a decoder gets. They can lie a little outside of the box of the given ones,
// and glTF's accessors must bound what a viewer sees.
void set_decoded_bounds(const draco::Mesh& mesh, const DracoQuantisation& quantisation,
                        SplittingEncoder& encoder, DracoMesh& out) {
    constexpr int kPositions = 0;
    DracoBox box{};
    if (quantisation.positions) {
        box = box_of(*quantisation.positions);
    } else {
        draco::AttributeQuantizationTransform transform;
        transform.ComputeParameters(*mesh.attribute(kPositions), quantisation.position_bits);
        box = {quantisation.position_bits,
               {transform.min_value(0), transform.min_value(1), transform.min_value(2)},
               transform.range()};
    }
    const draco::PointAttribute& cells = *encoder.GetPortableAttribute(kPositions);
    std::array<std::int32_t, 3> low = {}, high = {}, cell = {};
    for (draco::AttributeValueIndex i(0); i < static_cast<std::uint32_t>(cells.size()); ++i) {
        cells.GetValue(i, cell.data());
        if (i == 0) low = high = cell;
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], cell[axis]);
            high[axis] = std::max(high[axis], cell[axis]);
        }
    }
    draco::Dequantizer decoder;
    decoder.Init(box.range, static_cast<std::int32_t>((1u << box.bits) - 1));
    const auto decoded = [&](const std::array<std::int32_t, 3>& c) {
        return Vec3f{decoder(c[0]) + box.origin[0], decoder(c[1]) + box.origin[1],
                     decoder(c[2]) + box.origin[2]};
    };
    out.min = decoded(low);
    out.max = decoded(high);
}

}  // namespace

DracoMesh write_draco_stream(const draco::Mesh& mesh, const DracoQuantisation& quantisation, int threads) {
    draco::ExpertEncoder options(mesh);
    options.SetSpeedOptions(10 - quantisation.level, 10 - quantisation.level);
    options.SetTrackEncodedProperties(true);
    for (int i = 0; i < mesh.num_attributes(); ++i)
        quantise(options, i, mesh.attribute(i)->attribute_type(), quantisation);
    const bool tries = quantisation.level == 10 && mesh.num_attributes() > 1;
    std::future<std::vector<TriedAttribute>> tried;
    if (tries) tried = start_work(threads, [&] { return try_predictions(mesh, quantisation); });
    SplittingEncoder encoder(mesh, options.options());

    DracoMesh out;
    out.bytes = tries ? with_shortest(mesh, encoder, tried.get()) : encoder.bytes();
    out.vertices = static_cast<long long>(encoder.num_encoded_points());
    out.triangles = static_cast<long long>(encoder.num_encoded_faces());
    set_decoded_bounds(mesh, quantisation, encoder, out);
    const auto unique_id = [&](GeometryAttribute::Type type) {
        const draco::PointAttribute* const attribute = mesh.GetNamedAttribute(type);
        return attribute ? static_cast<int>(attribute->unique_id()) : -1;
    };
    out.position_id = unique_id(GeometryAttribute::POSITION);
    out.normal_id = unique_id(GeometryAttribute::NORMAL);
    out.texcoord_id = unique_id(GeometryAttribute::TEX_COORD);
    return out;
}

}  // namespace hexrelief

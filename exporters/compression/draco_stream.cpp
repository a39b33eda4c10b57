#include "exporters/compression/draco_stream.h"

#include <draco/attributes/attribute_quantization_transform.h>
#include <draco/compression/expert_encode.h>
#include <draco/compression/mesh/mesh_edgebreaker_encoder.h>
#include <draco/core/quantization_utils.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <future>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "pipeline/data/error.h"
#include "pipeline/data/start_work.h"

namespace hexrelief::exporters {
namespace {

using draco::GeometryAttribute;
using Bytes = std::vector<std::uint8_t>;

[[noreturn]] void refuse(const std::string& reason) {
    throw Error(ErrorKind::output, "cannot compress the mesh with Draco: " + reason);
}

// Draco's Edgebreaker encoder, which also records where the bytes of each attribute lie. An attribute's bytes
// do not depend on those of the others, so they can be replaced by others that decode to the same values.
class SplittingEncoder : public draco::MeshEdgebreakerEncoder {
  public:
    // `prepare` is called when the triangles have been encoded; it sets the attributes' values and options.
    SplittingEncoder(const draco::Mesh& mesh, const draco::EncoderOptions& options,
                     std::function<void()> prepare)
        : prepare_(std::move(prepare)) {
        SetMesh(mesh);
        const draco::Status status = Encode(options, &stream_);
        if (!status.ok()) refuse(status.error_msg_string());
    }
    Bytes bytes() const { return {stream_.data(), stream_.data() + stream_.size()}; }
    // Returns the bytes before all attributes.
    Bytes head() const { return {stream_.data(), stream_.data() + ends_.front()}; }
    // Returns the bytes of attribute i. Precondition: a speed below 6, at which each attribute
    // has its own encoder.
    Bytes attribute(std::size_t i) const {
        return {stream_.data() + ends_[i], stream_.data() + ends_[i + 1]};
    }

  protected:
    bool EncodePointAttributes() override {
        prepare_();
        return MeshEdgebreakerEncoder::EncodePointAttributes();
    }
    // As in the base class, for attributes that do not depend on later ones.
    bool EncodeAllAttributes() override {
        ends_ = {buffer()->size()};
        for (int i = 0; i < num_attributes_encoders(); ++i) {
            if (!attributes_encoder(i)->EncodeAttributes(buffer())) return false;
            ends_.push_back(buffer()->size());
        }
        return true;
    }

  private:
    const std::function<void()> prepare_;
    draco::EncoderBuffer stream_;
    std::vector<std::size_t> ends_;
};

void quantise(draco::ExpertEncoder& options, int attribute, GeometryAttribute::Type type,
              const DracoQuantisation& quantisation) {
    const auto set = [&](int bits, const auto& grid) {
        if (grid)
            set_box(options, attribute, *grid, quantisation.exact_boxes);
        else
            options.SetAttributeQuantization(attribute, bits);
    };
    if (type == GeometryAttribute::POSITION)
        set(quantisation.position_bits, quantisation.positions);
    else if (type == GeometryAttribute::NORMAL)
        options.SetAttributeQuantization(attribute, quantisation.normal_bits);
    else
        set(quantisation.texcoord_bits, quantisation.texcoords);
}

struct Trial {
    GeometryAttribute::Type type;
    int prediction;
};

// Predictions that Draco would not choose by itself. They save up to 13 % if surfaces are
// planes (venus), nothing otherwise.
constexpr Trial kTrials[] = {
    {GeometryAttribute::NORMAL, draco::PREDICTION_DIFFERENCE},
    {GeometryAttribute::TEX_COORD, draco::MESH_PREDICTION_PARALLELOGRAM},
    {GeometryAttribute::TEX_COORD, draco::MESH_PREDICTION_CONSTRAINED_MULTI_PARALLELOGRAM}};

struct TriedAttribute {
    GeometryAttribute::Type type;
    Bytes bytes;
};

using Tried = std::vector<TriedAttribute>;

void copy_triangles(const draco::Mesh& from, draco::Mesh& to) {
    to.set_num_points(from.num_points());
    to.SetNumFaces(from.num_faces());
    for (draco::FaceIndex face(0); face < from.num_faces(); ++face) to.SetFace(face, from.face(face));
}

// Adds an attribute like `from`, without its values.
int add_like(const draco::PointAttribute& from, draco::Mesh& to) {
    GeometryAttribute like;
    like.Init(from.attribute_type(), nullptr, from.num_components(), from.data_type(), from.normalized(),
              from.byte_stride(), 0);
    return to.AddAttribute(like, true, static_cast<draco::AttributeValueIndex::ValueType>(from.size()));
}

void copy_values(const draco::PointAttribute& from, draco::PointAttribute& to) {
    to.buffer()->Write(0, from.buffer()->data(), from.buffer()->data_size());
}

// Encodes all trials in one stream: a mesh with the same triangles, positions that cost next to nothing,
// because no trial predicts from them, and for each trial a copy of its attribute.
Tried try_predictions(const draco::Mesh& input, const DracoValuesReady& ready,
                      std::span<const Trial> trials) {
    draco::Mesh mesh;
    copy_triangles(input, mesh);
    GeometryAttribute position;
    position.Init(GeometryAttribute::POSITION, nullptr, 1, draco::DT_UINT8, false, 1, 0);
    mesh.AddAttribute(position, true, input.num_points());
    const Bytes zeros(input.num_points());
    mesh.attribute(0)->buffer()->Write(0, zeros.data(), zeros.size());
    draco::ExpertEncoder options(mesh);
    options.SetSpeedOptions(0, 0);
    options.SetAttributePredictionScheme(0, draco::PREDICTION_DIFFERENCE);
    Tried tried;
    for (const auto& [type, prediction] : trials) {
        const draco::PointAttribute* const values = input.GetNamedAttribute(type);
        if (!values) continue;
        const int index = add_like(*values, mesh);
        options.SetAttributePredictionScheme(index, prediction);
        tried.push_back({type, {}});
    }
    if (tried.empty()) return tried;
    const SplittingEncoder encoder(mesh, options.options(), [&] {
        const DracoQuantisation& quantisation = ready();
        for (std::size_t i = 0; i < tried.size(); ++i) {
            const int index = static_cast<int>(i) + 1;
            copy_values(*input.GetNamedAttribute(tried[i].type), *mesh.attribute(index));
            quantise(options, index, tried[i].type, quantisation);
        }
    });
    for (std::size_t i = 0; i < tried.size(); ++i) tried[i].bytes = encoder.attribute(i + 1);
    return tried;
}

constexpr int kAll = -1;

// Encodes the mesh. If `own` is one attribute, only that one gets Draco's usual prediction; all
// others take less time and more bytes. `prepare` is called when the triangles have been encoded
// and returns the quantisation.
std::unique_ptr<SplittingEncoder> encode(const draco::Mesh& mesh, int level, const DracoValuesReady& prepare,
                                         int own) {
    draco::ExpertEncoder options(mesh);
    options.SetSpeedOptions(10 - level, 10 - level);
    options.SetTrackEncodedProperties(true);
    return std::make_unique<SplittingEncoder>(mesh, options.options(), [&] {
        const DracoQuantisation& quantisation = prepare();
        for (int i = 0; i < mesh.num_attributes(); ++i) {
            quantise(options, i, mesh.attribute(i)->attribute_type(), quantisation);
            if (own != kAll && own != i)
                options.SetAttributePredictionScheme(i, draco::PREDICTION_DIFFERENCE);
        }
    });
}

// Returns the bytes of one attribute. Attributes after it are left out, since none is predicted
// from a later one.
Bytes encode_attribute(const draco::Mesh& input, int level, const DracoValuesReady& ready, int own) {
    draco::Mesh mesh;
    copy_triangles(input, mesh);
    for (int i = 0; i <= own; ++i) add_like(*input.attribute(i), mesh);
    const DracoValuesReady copy = [&]() -> const DracoQuantisation& {
        const DracoQuantisation& quantisation = ready();
        for (int i = 0; i <= own; ++i) copy_values(*input.attribute(i), *mesh.attribute(i));
        return quantisation;
    };
    return encode(mesh, level, copy, own)->attribute(static_cast<std::size_t>(own));
}

void take_shortest(Bytes& bytes, GeometryAttribute::Type type, const Tried& tried) {
    for (const TriedAttribute& other : tried)
        if (other.type == type && other.bytes.size() < bytes.size()) bytes = other.bytes;
}

// Sets the bounds of the decoded positions. They may lie a little outside the box of the given positions, and
// glTF's accessors must bound what a viewer sees.
void set_decoded_bounds(const draco::Mesh& mesh, const DracoQuantisation& quantisation,
                        SplittingEncoder& encoder, DracoMesh& out) {
    constexpr int kPositions = 0;
    DracoBox box{};
    if (quantisation.positions) {
        box = box_of(*quantisation.positions, quantisation.exact_boxes);
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

DracoMesh write_draco_stream(const draco::Mesh& mesh, int level, const DracoValuesReady& ready, int threads) {
    const int last = mesh.num_attributes() - 1;
    const bool tries = level == 10 && last > 0;
    // Two encodings: the mesh and the trials. With enough threads, one encoding per attribute and two for the
    // trials, of which the last takes as long as all others.
    const bool splits = tries && threads >= last + 3;
    const std::span<const Trial> trials(kTrials);
    std::vector<std::future<Tried>> tried;
    const auto start_trials = [&](std::span<const Trial> some) {
        tried.push_back(start_work(threads, [&, some] { return try_predictions(mesh, ready, some); }));
    };
    if (splits) start_trials(trials.first(trials.size() - 1));
    if (tries) start_trials(splits ? trials.last(1) : trials);
    std::vector<std::future<Bytes>> attributes;
    for (int i = 0; splits && i < last; ++i)
        attributes.push_back(start_work(threads, [&, i] { return encode_attribute(mesh, level, ready, i); }));
    const std::unique_ptr<SplittingEncoder> encoder = encode(mesh, level, ready, splits ? last : kAll);

    DracoMesh out;
    out.bytes = tries ? encoder->head() : encoder->bytes();
    Tried all;
    for (auto& some : tried) std::ranges::move(some.get(), std::back_inserter(all));
    for (int i = 0; tries && i <= last; ++i) {
        const auto index = static_cast<std::size_t>(i);
        Bytes bytes = index < attributes.size() ? attributes[index].get() : encoder->attribute(index);
        take_shortest(bytes, mesh.attribute(i)->attribute_type(), all);
        out.bytes.insert(out.bytes.end(), bytes.begin(), bytes.end());
    }
    out.vertices = static_cast<long long>(encoder->num_encoded_points());
    out.triangles = static_cast<long long>(encoder->num_encoded_faces());
    set_decoded_bounds(mesh, ready(), *encoder, out);
    const auto unique_id = [&](GeometryAttribute::Type type) {
        const draco::PointAttribute* const attribute = mesh.GetNamedAttribute(type);
        return attribute ? static_cast<int>(attribute->unique_id()) : -1;
    };
    out.position_id = unique_id(GeometryAttribute::POSITION);
    out.normal_id = unique_id(GeometryAttribute::NORMAL);
    out.texcoord_id = unique_id(GeometryAttribute::TEX_COORD);
    return out;
}

}  // namespace hexrelief::exporters

#include "scene/gltf/draco_attributes.h"

#include <cstring>
#include <type_traits>
#include <utility>

#include <draco/compression/attributes/sequential_attribute_decoders_controller.h>
#include <draco/compression/attributes/sequential_integer_attribute_decoder.h>
#include <draco/compression/attributes/sequential_quantization_attribute_decoder.h>
#include <fmt/format.h>

namespace parhelion {

namespace {

using Controller = draco::SequentialAttributeDecodersController;
using Sequencer = std::unique_ptr<draco::PointsSequencer>;
using Scheme = draco::PredictionSchemeTypedDecoderInterface<int32_t>;

// The order of the points is made by the mesh's decoder and private to the controller; an explicit instantiation may name it.
Sequencer& sequencer_of(Controller& controller);
template <Sequencer Controller::*member>
struct Reach {
    friend Sequencer& sequencer_of(Controller& controller) { return controller.*member; }
};
template struct Reach<&Controller::sequencer_>;

struct Limit {
    uint64_t corners;
    std::string& problem;
};

// A prediction of texture coordinates. Each value takes at most one turn from its data.
class LimitedScheme : public Scheme {
public:
    LimitedScheme(std::unique_ptr<Scheme> scheme, const Limit& limit) : scheme_(std::move(scheme)), limit_(limit) {}

    draco::PredictionSchemeMethod GetPredictionMethod() const override { return scheme_->GetPredictionMethod(); }
    const draco::PointAttribute* GetAttribute() const override { return scheme_->GetAttribute(); }
    bool IsInitialized() const override { return scheme_->IsInitialized(); }
    int GetNumParentAttributes() const override { return scheme_->GetNumParentAttributes(); }
    draco::GeometryAttribute::Type GetParentAttributeType(int i) const override { return scheme_->GetParentAttributeType(i); }
    bool SetParentAttribute(const draco::PointAttribute* attribute) override { return scheme_->SetParentAttribute(attribute); }
    bool AreCorrectionsPositive() override { return scheme_->AreCorrectionsPositive(); }
    draco::PredictionSchemeTransformType GetTransformType() const override { return scheme_->GetTransformType(); }
    bool ComputeOriginalValues(const int32_t* corrections, int32_t* values, int size, int components,
                               const draco::PointIndex* points) override {
        return scheme_->ComputeOriginalValues(corrections, values, size, components, points);
    }

    bool DecodePredictionData(draco::DecoderBuffer* buffer) override {
        if (GetPredictionMethod() == draco::MESH_PREDICTION_TEX_COORDS_DEPRECATED) {
            limit_.problem = "uses a prediction that version 2.2 of the Draco bitstream does not have";
            return false;
        }
        draco::DecoderBuffer ahead = *buffer;
        int32_t turns = 0;
        if (!ahead.Decode(&turns)) return false;
        if (turns < 0 || static_cast<uint64_t>(turns) > limit_.corners) {
            limit_.problem = fmt::format("turns texture coordinates {} times, but has {} corners", turns, limit_.corners);
            return false;
        }
        return scheme_->DecodePredictionData(buffer);
    }

private:
    std::unique_ptr<Scheme> scheme_;
    Limit limit_;
};

// The file's byte may have made any number of the enumeration (not checked in 1.5.5), which must not be read as a value of it.
template <class E>
bool lies_between(const E& value, E least, E end) {
    std::underlying_type_t<E> number;
    std::memcpy(&number, &value, sizeof(number));
    return std::cmp_greater_equal(number, static_cast<int>(least)) && std::cmp_less(number, static_cast<int>(end));
}

template <class Base>
class LimitedAttribute : public Base {
public:
    explicit LimitedAttribute(const Limit& limit) : limit_(limit) {}

protected:
    std::unique_ptr<Scheme> CreateIntPredictionScheme(draco::PredictionSchemeMethod method,
                                                      draco::PredictionSchemeTransformType transform) override {
        if (!lies_between(method, draco::PREDICTION_NONE, draco::NUM_PREDICTION_SCHEMES) ||
            !lies_between(transform, draco::PREDICTION_TRANSFORM_NONE, draco::NUM_PREDICTION_SCHEME_TRANSFORM_TYPES))
            return nullptr;  // the values stay as they are stored
        std::unique_ptr<Scheme> scheme = Base::CreateIntPredictionScheme(method, transform);
        if (!scheme) return scheme;
        const draco::PredictionSchemeMethod made = scheme->GetPredictionMethod();  // a plainer one where `method` cannot be had
        if (made != draco::MESH_PREDICTION_TEX_COORDS_PORTABLE && made != draco::MESH_PREDICTION_TEX_COORDS_DEPRECATED) return scheme;
        return std::make_unique<LimitedScheme>(std::move(scheme), limit_);
    }

private:
    Limit limit_;
};

class LimitedController : public Controller {
public:
    LimitedController(Sequencer sequencer, const Limit& limit) : Controller(std::move(sequencer)), limit_(limit) {}

protected:
    std::unique_ptr<draco::SequentialAttributeDecoder> CreateSequentialDecoder(uint8_t type) override {
        switch (type) {
            case draco::SEQUENTIAL_ATTRIBUTE_ENCODER_INTEGER:
                return std::make_unique<LimitedAttribute<draco::SequentialIntegerAttributeDecoder>>(limit_);
            case draco::SEQUENTIAL_ATTRIBUTE_ENCODER_QUANTIZATION:
                return std::make_unique<LimitedAttribute<draco::SequentialQuantizationAttributeDecoder>>(limit_);
            default:  // plain values are not predicted, normals never as texture coordinates
                return Controller::CreateSequentialDecoder(type);
        }
    }

private:
    Limit limit_;
};

}  // namespace

std::unique_ptr<draco::AttributesDecoderInterface> limited_attributes_decoder(draco::AttributesDecoderInterface& made, uint64_t corners,
                                                                             std::string& problem) {
    // Decoders of meshes make no other kind.
    return std::make_unique<LimitedController>(std::move(sequencer_of(static_cast<Controller&>(made))), Limit{corners, problem});
}

}  // namespace parhelion

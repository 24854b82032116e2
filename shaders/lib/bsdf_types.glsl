// What goes into the BSDF and comes out of it.
#ifndef PARHELION_LIB_BSDF_TYPES_GLSL
#define PARHELION_LIB_BSDF_TYPES_GLSL

const uint kLobeDiffuse = 0u;
const uint kLobeSpecular = 1u;
const uint kLobeTransmission = 2u;
const uint kLobeNone = 3u;

// The parts of a material that only some scenes have (transmission, clear coat, sheen) cost nothing in shaders compiled without
// LAYERS; SceneHeader::features says what a scene needs.
#ifdef LAYERS
const bool kLayers = true;
#else
const bool kLayers = false;
#endif

// What the material says at a point of a surface. Factors and textures are multiplied already; colours are linear Rec. 709.
struct BsdfParameters {
    vec3 base_color;
    float metallic, roughness;     // perceptual roughness
    float ior;                     // of the material; 0: reflects everything (KHR_materials_ior)
    float specular;                // KHR_materials_specular; 0 with metallic 0: a pure Lambert surface
    vec3 specular_color;
    // Below: with LAYERS only.
    float transmission;            // KHR_materials_transmission
    bool thin;                     // the transmitting surface is a wall without thickness: no refraction, equal from both sides
    float eta;                     // index of refraction beyond the surface over that on wo's side
    bool inside;                   // wo is in the volume behind the surface, where no layer lies
    float coat, coat_roughness;    // KHR_materials_clearcoat
    vec3 sheen_color;              // KHR_materials_sheen
    float sheen_roughness;
};

// Value times cosine, by class of the path that takes it (docs/path-space.md).
struct BsdfValue {
    vec3 diffuse, specular, transmission;
};
vec3 total(BsdfValue value) { return value.diffuse + value.specular + value.transmission; }
BsdfValue scale(BsdfValue value, vec3 by) { return BsdfValue(value.diffuse * by, value.specular * by, value.transmission * by); }
const BsdfValue kNoBsdfValue = BsdfValue(vec3(0.0), vec3(0.0), vec3(0.0));

struct BsdfSample {
    vec3 wi;
    BsdfValue weight;  // f cos / pdf of all lobes together, by class; of a delta lobe, of that lobe alone
    float pdf;         // per solid angle, of all lobes together; < 0: a delta lobe, which no light sample finds
    uint lobe;         // that was drawn; kLobeNone: absorbed
};
const BsdfSample kNoBsdfSample = BsdfSample(vec3(0.0), kNoBsdfValue, 0.0, kLobeNone);
#endif

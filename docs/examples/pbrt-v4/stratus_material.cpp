#include <pbrt/materials.h>
#include <pbrt/paramdict.h>
#include <pbrt/textures.h>
#include <pbrt/util/error.h>
#include <pbrt/util/file.h>

#include <exception>
#include <map>
#include <memory>
#include <mutex>

namespace pbrt {
namespace {

/// Tables are read once, and shared by materials.
const StratusTable* TableIn(const std::string& path, const FileLoc* loc) {
    static std::mutex mutex;
    static std::map<std::string, std::unique_ptr<StratusTable>> tables;
    const std::lock_guard<std::mutex> lock(mutex);
    std::unique_ptr<StratusTable>& table = tables[path];
    try {
        if (!table) table = std::make_unique<StratusTable>(path);
    } catch (const std::exception& refusal) {
        ErrorExit(loc, "%s", refusal.what());
    }
    return table.get();
}

StratusTexture TextureNamed(const std::string& name, SpectrumType type, Float standard,
                            const TextureParameterDictionary& parameters, Allocator alloc) {
    StratusTexture texture;
    texture.spectrum = parameters.GetSpectrumTextureOrNull(name + "spectrum", type, alloc);
    if (!texture.spectrum) texture.number = parameters.GetFloatTextureOrNull(name, alloc);
    if (!texture.spectrum && !texture.number)
        texture.number = alloc.new_object<FloatConstantTexture>(standard);
    return texture;
}

}  // namespace

StratusMaterial* StratusMaterial::Create(const TextureParameterDictionary& parameters,
                                         Image* normalMap, const FileLoc* loc, Allocator alloc) {
    const std::string name = parameters.GetOneString("filename", "");
    if (name.empty())
        ErrorExit(loc, "stratus: filename must be that of a packed table (.stratus), got none");
    return alloc.new_object<StratusMaterial>(
        TableIn(ResolveFilename(name), loc),
        TextureNamed("opticaldepth", SpectrumType::Unbounded, 1, parameters, alloc),
        TextureNamed("albedo", SpectrumType::Albedo, 1, parameters, alloc),
        parameters.GetOneFloat("scale", 1), parameters.GetFloatTextureOrNull("displacement", alloc),
        normalMap);
}

}  // namespace pbrt

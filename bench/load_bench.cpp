// How long tables take to load, beside reading their bytes and what the formats' own libraries
// take.
//
// A table whose samples are 64 MB in memory, baked, in both formats, from a file that the system
// keeps in memory:
//
//     plain_read      the file's bytes, nothing else; `floats`: a file of nothing but the samples
//     library_read    H5Dread, or OpenEXR's readPixels, of all samples; checks nothing
//     read_table      what `stratus::io` gives: sealed, checked, ready for lookups
#include <stratus/bake/bake.h>
#include <stratus/io/table_file.h>

#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <benchmark/benchmark.h>
#include <hdf5.h>

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <unistd.h>
#include <vector>

namespace {

/// Saturn's rings, with as many albedos as make it 64 MB.
constexpr const char* recipe = R"(
phase_function = "0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5"
tolerance = 1e-3
optical_depth = { min = 0.01, max = 8.0 }
albedo = { min = 0.0, max = 1.0 }
[discretisation]
nodes = 16
modes = 9
mu_samples = 32
azimuth_samples = 13
optical_depth_samples_per_octave = 3
albedo_samples = 20
)";

/// Both files of one baked table, in a folder of their own that goes with the program.
class Files {
  public:
    Files() {
        std::filesystem::create_directories(folder_);
        const stratus::Table table = stratus::solve_table(stratus::parse_recipe(recipe));
        for (const char* ending : {".h5", ".exr"}) stratus::write_table(table, path(ending));
        std::ofstream floats(path(".floats"), std::ios::binary);
        for (const auto* side : {&table.reflection_multiple, &table.transmission_multiple}) {
            samples_ += side->size();
            floats.write(reinterpret_cast<const char*>(side->data()),
                         static_cast<std::streamsize>(side->size() * sizeof(float)));
        }
    }
    ~Files() { std::filesystem::remove_all(folder_); }

    std::string path(const char* ending) const { return (folder_ / "table").string() + ending; }
    std::size_t samples() const { return samples_; }

  private:
    std::filesystem::path folder_ = std::filesystem::temp_directory_path() /
                                    ("stratus-load-bench-" + std::to_string(::getpid()));
    std::size_t samples_ = 0;
};

const Files& files() {
    static const Files files;
    return files;
}

void count_bytes(benchmark::State& state, const char* ending) {
    state.counters["MB_in_memory"] = 4e-6 * static_cast<double>(files().samples());
    state.counters["MB_in_file"] =
        1e-6 * static_cast<double>(std::filesystem::file_size(files().path(ending)));
}

void plain_read(benchmark::State& state, const char* ending) {
    const std::string path = files().path(ending);
    for (auto _ : state) {
        std::vector<char> bytes(std::filesystem::file_size(path));
        std::FILE* const file = std::fopen(path.c_str(), "rb");
        benchmark::DoNotOptimize(std::fread(bytes.data(), 1, bytes.size(), file));
        std::fclose(file);
    }
    count_bytes(state, ending);
}

constexpr const char* sides[] = {"reflection_multiple", "transmission_multiple"};

void read_with_hdf5(const std::string& path, std::vector<float>& samples) {
    float* into = samples.data();
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    for (const char* side : sides) {
        const hid_t dataset = H5Dopen2(file, side, H5P_DEFAULT);
        H5Dread(dataset, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, into);
        into += samples.size() / std::size(sides);
        H5Dclose(dataset);
    }
    H5Fclose(file);
}

void read_with_openexr(const std::string& path, std::vector<float>& samples) {
    float* into = samples.data();
    Imf::MultiPartInputFile file(path.c_str(), 0);
    for (const char* side : sides) {
        int number = 0;
        while (file.header(number).name() != side) ++number;
        const Imath::Box2i& window = file.header(number).dataWindow();
        const std::size_t width = static_cast<std::size_t>(window.max.x) + 1;
        Imf::FrameBuffer buffer;
        buffer.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(into), sizeof(float),
                                      sizeof(float) * width));
        into += samples.size() / std::size(sides);
        Imf::InputPart part(file, number);
        part.setFrameBuffer(buffer);
        part.readPixels(window.min.y, window.max.y);
    }
}

using Read = void (*)(const std::string&, std::vector<float>&);

void library_read(benchmark::State& state, const char* ending, Read read) {
    const std::string path = files().path(ending);
    for (auto _ : state) {
        std::vector<float> samples(files().samples());
        read(path, samples);
        benchmark::DoNotOptimize(samples.data());
    }
    count_bytes(state, ending);
}

void read_table(benchmark::State& state, const char* ending) {
    const std::string path = files().path(ending);
    for (auto _ : state) benchmark::DoNotOptimize(stratus::read_table(path).sample_count());
    count_bytes(state, ending);
}

BENCHMARK_CAPTURE(plain_read, floats, ".floats")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(plain_read, h5, ".h5")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(library_read, h5, ".h5", read_with_hdf5)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_table, h5, ".h5")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(plain_read, exr, ".exr")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(library_read, exr, ".exr", read_with_openexr)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_table, exr, ".exr")->Unit(benchmark::kMillisecond);

}  // namespace

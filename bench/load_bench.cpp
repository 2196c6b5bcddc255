// Times to load a table, compared with reading the bytes alone and with the formats' own libraries.
//
// A baked table with 64 MB of samples, in both formats, from files in the page cache:
//
//     plain_read      reads the bytes of the file; `floats`: of a file of the samples alone
//     library_read    H5Dread or OpenEXR's readPixels of all samples, without any checks
//     read_table      stratus::io: all checks, ready for lookups
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

/// Saturn's rings, with enough albedos for 64 MB.
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

/// One baked table in both formats, in a temporary folder that is removed at exit.
class Files {
  public:
    Files() {
        std::filesystem::create_directories(folder_);
        const stratus::Table table = stratus::solve_table(stratus::parse_recipe(recipe));
        for (const char* ending : {".h5", ".exr"}) stratus::write_table(table, path(ending));
        std::ofstream floats(path(".floats"), std::ios::binary);
        for (const auto* samples : {&table.reflection_multiple, &table.transmission_multiple}) {
            samples_ += samples->size();
            floats.write(reinterpret_cast<const char*>(samples->data()),
                         static_cast<std::streamsize>(samples->size() * sizeof(float)));
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

constexpr const char* datasets[] = {"reflection_multiple", "transmission_multiple"};

void read_with_hdf5(const std::string& path, std::vector<float>& samples) {
    float* into = samples.data();
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    for (const char* name : datasets) {
        const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT);
        H5Dread(dataset, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, into);
        into += samples.size() / std::size(datasets);
        H5Dclose(dataset);
    }
    H5Fclose(file);
}

void read_with_openexr(const std::string& path, std::vector<float>& samples) {
    float* into = samples.data();
    Imf::MultiPartInputFile file(path.c_str(), 0);
    for (const char* name : datasets) {
        int number = 0;
        while (file.header(number).name() != name) ++number;
        const Imath::Box2i& window = file.header(number).dataWindow();
        const std::size_t width = static_cast<std::size_t>(window.max.x) + 1;
        Imf::FrameBuffer buffer;
        buffer.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(into), sizeof(float),
                                      sizeof(float) * width));
        into += samples.size() / std::size(datasets);
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

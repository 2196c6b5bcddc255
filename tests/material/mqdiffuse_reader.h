// A reader of mqdiffuse files, as Eradiate reads them: named axes, straight lines between samples,
// azimuths around the circle.
#pragma once

#include <hdf5.h>
#include <hdf5_hl.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus::test {

class MqdiffuseReader {
  public:
    explicit MqdiffuseReader(const std::filesystem::path& path) {
        const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
        if (file < 0) throw std::runtime_error("open");
        const hid_t brdf = H5Dopen2(file, "brdf", H5P_DEFAULT);
        const char* const names[] = {"cos_theta_o", "phi_d", "cos_theta_i"};
        std::size_t count = 1;
        for (unsigned d = 0; d < 3; ++d) {
            const hid_t axis = H5Dopen2(file, names[d], H5P_DEFAULT);
            if (H5DSis_scale(axis) <= 0 || H5DSis_attached(brdf, axis, d) <= 0)
                throw std::runtime_error(std::string(names[d]) + " is not a dimension's scale");
            if (H5Aexists(axis, "units") <= 0) throw std::runtime_error("units");
            const hid_t space = H5Dget_space(axis);
            axes[d].resize(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
            count *= axes[d].size();
            H5Sclose(space);
            H5Dread(axis, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, axes[d].data());
            H5Dclose(axis);
        }
        values_.resize(count);
        H5Dread(brdf, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values_.data());
        H5Dclose(brdf);
        H5Fclose(file);
    }

    std::array<std::vector<double>, 3> axes;

    /// f; phi_d from 0 to 2 pi between the directions, both away from the surface.
    double operator()(double cos_o, double phi_d, double cos_i) const {
        const double place[3] = {cos_o * static_cast<double>(axes[0].size() - 1),
                                 phi_d / (2 * pi_) * static_cast<double>(axes[1].size()),
                                 cos_i * static_cast<double>(axes[2].size() - 1)};
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            double weight = 1;
            std::size_t at[3];
            for (int d = 0; d < 3; ++d) {
                const std::size_t size = axes[static_cast<std::size_t>(d)].size();
                const std::size_t first =
                    std::min(static_cast<std::size_t>(place[d]), d == 1 ? size - 1 : size - 2);
                const double along = place[d] - static_cast<double>(first);
                const bool next = (corner >> d) & 1;
                weight *= next ? along : 1 - along;
                at[d] = (first + (next ? 1 : 0)) % size;
            }
            sum += weight * static_cast<double>(
                                values_[(at[0] * axes[1].size() + at[1]) * axes[2].size() + at[2]]);
        }
        return sum;
    }

  private:
    static constexpr double pi_ = 3.14159265358979323846;
    std::vector<float> values_;
};

}  // namespace stratus::test

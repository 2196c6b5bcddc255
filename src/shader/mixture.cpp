#include <stratus/shader/shader.h>

#include <stratus/runtime/argument.h>
#include <stratus/runtime/diffusion.h>
#include <stratus/runtime/number_text.h>

#include <algorithm>
#include <cstddef>

namespace stratus {

Table table_of_share(const Table& table, double share) {
    require(is_mixture(table.family), "table_of_share", "table", "one with a mixture axis alone",
            table.has_family() ? "another family" : "none");
    const AxisView axis = table.family[0].axis.view();
    require(share >= axis.lowest && share <= axis.highest, "table_of_share", "mixture",
            "in [" + shortest_text(axis.lowest) + ", " + shortest_text(axis.highest) + "]", share);
    const Stencil stencil = axis.stencil(share);
    Table sum = table_of_member(table, static_cast<std::size_t>(stencil.first));
    for_each_of_members(
        [&](auto& numbers) {
            for (auto& number : numbers) number = 0;
        },
        sum);
    for (int k = 0; k < std::min(stencil_size, axis.count); ++k) {
        if (stencil.weight[k] == 0) continue;
        const Table one = table_of_member(table, static_cast<std::size_t>(stencil.first + k));
        for_each_of_members(
            [&](auto& numbers, const auto& more) {
                for (std::size_t n = 0; n < numbers.size(); ++n)
                    numbers[n] += stencil.weight[k] * more[n];
            },
            sum, one);
    }
    sum.phase_function = table.view().at_mixture(share).chosen_phase_function();
    sum.extrapolation_length = mixed_extrapolation_length(table.extrapolation_length,
                                                          table.second_extrapolation_length, share);
    prepare(sum);
    return sum;
}

}  // namespace stratus

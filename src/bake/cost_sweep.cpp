#include "cost_sweep.h"

#include <stratus/bake/accuracy.h>

#include <algorithm>

namespace stratus {

bool CostBudget::is_time_left(double share, double needed) const {
    return seconds_since(started_) + needed < share * options_.seconds;
}

void CostBudget::say(const std::string& line) const {
    if (options_.note) options_.note(line);
}

void CostBudget::show(const char* stage) const {
    if (options_.progress)
        options_.progress(std::min(0.999, seconds_since(started_) / options_.seconds), stage);
}

SolverOptions solver_of(const Recipe& recipe) {
    SolverOptions solver;
    solver.orders = recipe.orders;
    return solver;
}

void set_errors(CostPoint& point, std::vector<double> errors) {
    point.error_median = error_quantile(errors, 0.5);
    point.error_99_9 = error_quantile(errors, 0.999);
    point.error_largest = error_quantile(errors, 1);
}

}  // namespace stratus

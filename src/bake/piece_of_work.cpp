#include "piece_of_work.h"

namespace stratus {

WorkLog part_of(const WorkLog& log, const std::string& part) {
    WorkLog named;
    if (log.find)
        named.find = [find = log.find, part](const std::string& piece) {
            return find(part + ", " + piece);
        };
    if (log.keep)
        named.keep = [keep = log.keep, part](const std::string& piece,
                                             std::span<const char> result) {
            keep(part + ", " + piece, result);
        };
    named.stop = log.stop;
    return named;
}

}  // namespace stratus

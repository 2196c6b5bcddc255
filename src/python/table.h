// A table as Python holds it: dense or packed.
#pragma once

#include <stratus/table/packed_table.h>
#include <stratus/table/table.h>

#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace stratus::python {

class AnyTable {
  public:
    explicit AnyTable(Table table) : own_(std::move(table)) {}
    explicit AnyTable(PackedTable table) : own_(std::move(table)) {}
    AnyTable(const AnyTable&) = delete;
    AnyTable& operator=(const AnyTable&) = delete;

    /// By its name's ending: .h5, .exr or .stratus.
    static std::shared_ptr<AnyTable> read(const std::string& path);

    /// Null where it is not packed.
    const PackedTable* packed() const { return std::get_if<PackedTable>(&own_); }

    /// Of a packed one without samples.
    const Table& table() const { return packed() ? packed()->header() : std::get<Table>(own_); }

    TableView view() const { return packed() ? packed()->view() : table().view(); }

  private:
    std::variant<Table, PackedTable> own_;
};

}  // namespace stratus::python

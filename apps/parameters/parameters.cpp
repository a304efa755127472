// Publishes the parameters of all nodes, and changes them on request.
#include "parameters.hpp"

#include <array>
#include <bit>
#include <string_view>

#include "pack.hpp"
#include "stator/math/bits.hpp"
#include "validity.hpp"

namespace stator::apps::parameters {

namespace {

using Action = ParameterRequest::Action;
using Result = ParameterValue::Result;
using Name = decltype(ParameterRequest::name);

template <class Type>
constexpr bool kHasTypes =
    Type{0} == Type::kFloat&& Type{1} == Type::kInt32&& Type{2} == Type::kBool;
static_assert(kHasTypes<ParameterType>);
static_assert(kHasTypes<ParameterRequest::Type>);
static_assert(kHasTypes<ParameterValue::Type>);

std::string_view text(const Name& name) {
    size_t length = 0;
    while (length < name.size() && name[length] != 0) ++length;
    return {reinterpret_cast<const char*>(name.data()), length};
}

// By name or id if there is one, else by index; null if it does not exist.
const ParameterRow* find(const ParameterPort& parameters, const ParameterRequest& request) {
    const auto rows = parameters.rows();
    const std::string_view name = text(request.name);
    if (name.empty()) return request.index < rows.size() ? &rows[request.index] : nullptr;
    for (const ParameterRow& row : rows) {
        if (name == row.is.name || name == row.is.id) return &row;
    }
    return nullptr;
}

// The same value again is written, but not published.
Result set(ParametersPorts& ports, const ParameterRow& row, const ParameterRequest& request) {
    ParameterPort& parameters = ports.parameters;
    const bool is_float = row.type == ParameterType::kFloat;
    if (static_cast<ParameterType>(request.type) != row.type) return Result::kWrongType;
    if (is_float && math::is_nan(request.float_value)) return Result::kNotANumber;
    const auto value = is_float ? std::bit_cast<ParameterBits>(request.float_value)
                                : std::bit_cast<ParameterBits>(request.int_value);
    if (!is_in_range(row, value)) return Result::kOutOfRange;
    if (row.is_fixed) return Result::kFixed;
    const bool is_armed =
        ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
    if (row.on_ground && is_armed) return Result::kArmed;
    if (value != parameters.value(row)) parameters.publish(row, value);
    return Result::kWritten;
}

template <class Text>
void copy_text(const char* from, Text& to) {
    for (size_t i = 0; i < to.size() && from[i] != 0; ++i) to[i] = static_cast<uint8_t>(from[i]);
}

ParameterValue answer_about(const ParameterPort& parameters, const ParameterRow& row) {
    ParameterValue answer{.type = static_cast<ParameterValue::Type>(row.type),
                          .index = static_cast<uint16_t>(&row - parameters.rows().data())};
    const ParameterBits value = parameters.value(row);
    if (row.type == ParameterType::kFloat) {
        answer.float_value = as_float(value);
        answer.float_least = as_float(row.least);
        answer.float_most = as_float(row.most);
        answer.float_default = as_float(row.standard);
    } else {
        answer.int_value = as_int(value);
        answer.int_least = as_int(row.least);
        answer.int_most = as_int(row.most);
        answer.int_default = as_int(row.standard);
    }
    answer.on_ground = row.on_ground;
    copy_text(row.is.name, answer.name);
    copy_text(row.is.id, answer.id);
    return answer;
}

// What MAVLink's stations ask for under this name, to know whether they know all values: CRC-32,
// without the inversions before and after, of all ids and values.
constexpr std::string_view kHash = "_HASH_CHECK";

ParameterValue hash_of(const ParameterPort& parameters) {
    uint32_t hash = 0;
    for (const ParameterRow& row : parameters.rows()) {
        hash = hash_parameter(hash, row.is.id, parameters.value(row));
    }
    ParameterValue answer{.result = Result::kRead,
                          .type = ParameterValue::Type::kInt32,
                          .index = UINT16_MAX,
                          .int_value = std::bit_cast<int32_t>(hash)};
    copy_text(kHash.data(), answer.name);
    copy_text(kHash.data(), answer.id);
    return answer;
}

}  // namespace

void Parameters::step(ParametersPorts& ports) {
    keeper_.take(ports);
    if (ports.request.next()) answer(ports);
    if (ports.file_request.next()) read_file(ports);
    keeper_.work(ports);
}

void Parameters::read_file(ParametersPorts& ports) {
    const FileRequest& request = *ports.file_request;
    if (request.file != FileRequest::File::kParameters) return;
    ports.file.publish([&] { return read_pack(ports.parameters, request); });
}

void Parameters::answer(ParametersPorts& ports) {
    const ParameterRequest& request = *ports.request;
    const ParameterRow* const row = find(ports.parameters, request);
    Result result = row == nullptr ? Result::kUnknown : Result::kRead;
    if (row != nullptr && request.action == Action::kSet) {
        result = set(ports, *row, request);
        const auto place = static_cast<unsigned>(row - ports.parameters.rows().data());
        if (result == Result::kWritten) keeper_.change(ports, place);
    }
    const bool is_hash =
        row == nullptr && request.action == Action::kGet && text(request.name) == kHash;
    if (is_hash) result = Result::kRead;
    ports.value.publish([&] {
        ParameterValue value{};
        if (row != nullptr) value = answer_about(ports.parameters, *row);
        if (is_hash) value = hash_of(ports.parameters);
        value.requester = static_cast<ParameterValue::Requester>(request.requester);
        value.tag = request.tag;
        value.result = result;
        value.count = static_cast<uint16_t>(ports.parameters.rows().size());
        return value;
    });
}

}  // namespace stator::apps::parameters

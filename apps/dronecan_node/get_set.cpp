// DroneCAN's param.GetSet in the words of the node that has all parameters, and back.
#include "get_set.hpp"

#include <algorithm>

namespace stator::apps::dronecan_node {

namespace {

using dronecan::protocol::param::GetSet;
using dronecan::protocol::param::NumericValue;
using dronecan::protocol::param::Value;
using Type = ParameterRequest::Type;

bool fits(const Value& value) {
    if (value.tag == Value::Tag::kIntegerValue) {
        return value.integer_value >= INT32_MIN && value.integer_value <= INT32_MAX;
    }
    return value.tag == Value::Tag::kRealValue || value.tag == Value::Tag::kBooleanValue;
}

void take_value(const Value& value, ParameterRequest& request) {
    if (value.tag == Value::Tag::kRealValue) {
        request.type = Type::kFloat;
        request.float_value = value.real_value;
    } else if (value.tag == Value::Tag::kBooleanValue) {
        request.type = Type::kBool;
        request.int_value = value.boolean_value;
    } else {
        request.type = Type::kInt32;
        request.int_value = static_cast<int32_t>(value.integer_value);
    }
}

Value value_of(ParameterValue::Type type, float real, int32_t whole) {
    if (type == ParameterValue::Type::kFloat) {
        return {.tag = Value::Tag::kRealValue, .real_value = real};
    }
    if (type == ParameterValue::Type::kBool) {
        return {.tag = Value::Tag::kBooleanValue, .boolean_value = static_cast<uint8_t>(whole)};
    }
    return {.tag = Value::Tag::kIntegerValue, .integer_value = whole};
}

NumericValue bound_of(ParameterValue::Type type, float real, int32_t whole) {
    if (type == ParameterValue::Type::kFloat) {
        return {.tag = NumericValue::Tag::kRealValue, .real_value = real};
    }
    if (type == ParameterValue::Type::kBool) return {};
    return {.tag = NumericValue::Tag::kIntegerValue, .integer_value = whole};
}

}  // namespace

ParameterRequest to_request(const GetSet::Request& request, uint8_t tag, bool may_write) {
    ParameterRequest result{
        .requester = ParameterRequest::Requester::kCan, .tag = tag, .index = request.index};
    std::ranges::copy(request.name.view(), result.name.begin());
    if (may_write && fits(request.value)) {
        result.action = ParameterRequest::Action::kSet;
        take_value(request.value, result);
    }
    return result;
}

GetSet::Response to_response(const ParameterValue& value) {
    GetSet::Response response;
    if (value.result == ParameterValue::Result::kUnknown) return response;
    response.value = value_of(value.type, value.float_value, value.int_value);
    response.default_value = value_of(value.type, value.float_default, value.int_default);
    response.min_value = bound_of(value.type, value.float_least, value.int_least);
    response.max_value = bound_of(value.type, value.float_most, value.int_most);
    const auto end = std::ranges::find(value.name, uint8_t{0});
    response.name.assign(std::span(value.name.begin(), end));
    return response;
}

}  // namespace stator::apps::dronecan_node

// Parameters on their way to stations, and back.
#include "parameter_transfer.hpp"

#include <algorithm>
#include <bit>
#include <string_view>

namespace stator::apps::mavlink {

namespace {

using Result = ParameterValue::Result;
namespace error = mav::mav_param_error;

constexpr std::string_view kHash = "_HASH_CHECK";
constexpr uint16_t kNoIndex = UINT16_MAX;

bool is_for(uint8_t system, uint8_t component, mav::Address own) {
    return system == own.system && (component == own.component || component == 0);
}

uint32_t error_of(Result result) {
    switch (result) {
        case Result::kUnknown:
            return error::kDoesNotExist;
        case Result::kWrongType:
            return error::kTypeMismatch;
        case Result::kFixed:
            return error::kReadOnly;
        case Result::kArmed:
            return error::kPermissionDenied;
        case Result::kOutOfRange:
        case Result::kNotANumber:
        default:
            return error::kValueOutOfRange;
    }
}

bool is_hash(const std::array<char, 16>& id) {
    return std::equal(kHash.begin(), kHash.end(), id.begin()) && id[kHash.size()] == '\0';
}

}  // namespace

void ParameterTransfer::queue(const Question& question) {
    if (waiting_ == kQueue) return;
    queue_[(begin_ + waiting_) % kQueue] = question;
    ++waiting_;
}

bool ParameterTransfer::handle(Link& link, unsigned number, const mav::Frame& frame,
                               const MavlinkPorts& ports) {
    const mav::Address own = link.own();
    const bool has_any = ports.parameter_request.is_connected();
    switch (frame.id) {
        case mav::ParamRequestList::kId: {
            const auto m = mav::decode<mav::ParamRequestList>(frame.payload);
            if (is_for(m.target_system, m.target_component, own) && has_any) list_next_[number] = 0;
            return true;
        }
        case mav::ParamRequestRead::kId: {
            const auto m = mav::decode<mav::ParamRequestRead>(frame.payload);
            if (!is_for(m.target_system, m.target_component, own)) return true;
            if (!has_any) {
                refuse(link, frame.source, m.param_id, m.param_index, error::kDoesNotExist);
                return true;
            }
            Question question{.is_one = true, .line = number, .from = frame.source};
            if (m.param_index < 0) question.id = m.param_id;
            if (m.param_index >= 0) question.index = static_cast<uint16_t>(m.param_index);
            queue(question);
            return true;
        }
        case mav::ParamSet::kId: {
            const auto m = mav::decode<mav::ParamSet>(frame.payload);
            if (!is_for(m.target_system, m.target_component, own)) return true;
            if (is_hash(m.param_id)) {  // the station knows all values
                list_next_[number] = kNoList;
                return true;
            }
            const bool is_float = m.param_type == mav::mav_param_type::kReal32;
            const bool is_int = m.param_type == mav::mav_param_type::kInt32;
            if (!link.allows(Right::kTune)) {
                refuse(link, frame.source, m.param_id, -1, error::kPermissionDenied);
                return true;
            }
            if (!has_any || (!is_float && !is_int)) {
                refuse(link, frame.source, m.param_id, -1,
                       has_any ? error::kTypeMismatch : error::kDoesNotExist);
                return true;
            }
            queue(
                {.is_one = true,
                 .line = number,
                 .from = frame.source,
                 .id = m.param_id,
                 .sets = true,
                 .type = is_float ? ParameterRequest::Type::kFloat : ParameterRequest::Type::kInt32,
                 .value = m.param_value});
            return true;
        }
        default:
            return false;
    }
}

// Lists take turns, as far as their lines have room.
void ParameterTransfer::ask_next(const Link& link, MavlinkPorts& ports) {
    if (waiting_ != 0) {
        const Question question = queue_[begin_];
        begin_ = (begin_ + 1) % kQueue;
        --waiting_;
        return ask(question, ports);
    }
    const unsigned line = list_line_;
    list_line_ = (list_line_ + 1) % kLines;
    if (list_next_[line] == kNoList || !link.has_room_for_bulk()) return;
    ask({.is_one = true, .is_of_list = true, .line = line, .index = list_next_[line]}, ports);
}

void ParameterTransfer::ask(const Question& question, MavlinkPorts& ports) {
    asked_ = question;
    asked_us_ = ports.now;
    ++tag_;
    ports.parameter_request.publish([&] {
        ParameterRequest request{.requester = ParameterRequest::Requester::kMavlink,
                                 .tag = tag_,
                                 .type = question.type,
                                 .index = question.index};
        for (std::size_t i = 0; i < question.id.size() && question.id[i] != '\0'; ++i) {
            request.name[i] = static_cast<uint8_t>(question.id[i]);
        }
        if (!question.sets) return request;
        request.action = ParameterRequest::Action::kSet;
        if (question.type == ParameterRequest::Type::kFloat) {
            request.float_value = question.value;
        } else {
            request.int_value = std::bit_cast<int32_t>(question.value);
        }
        return request;
    });
}

bool ParameterTransfer::is_answer(const ParameterValue& value) const {
    return asked_.is_one && value.requester == ParameterValue::Requester::kMavlink &&
           value.tag == tag_;
}

// A bool is an int32 to stations.
bool ParameterTransfer::is_asked_again(const ParameterValue& value, MavlinkPorts& ports) {
    const bool is_bool = asked_.sets && value.result == Result::kWrongType &&
                         value.type == ParameterValue::Type::kBool &&
                         asked_.type == ParameterRequest::Type::kInt32;
    if (!is_bool) return false;
    Question again = asked_;
    again.type = ParameterRequest::Type::kBool;
    ask(again, ports);
    return true;
}

void ParameterTransfer::refuse(Link& link, const mav::Address& to,
                               const std::array<char, kIdLength>& id, int16_t index,
                               uint32_t why) const {
    link.send(mav::ParamError{.param_index = index,
                              .target_system = to.system,
                              .target_component = to.component,
                              .param_id = id,
                              .error = static_cast<uint8_t>(why)});
}

void ParameterTransfer::tell(Link& link, const ParameterValue& value) const {
    if (value.result != Result::kRead && value.result != Result::kWritten) {
        if (asked_.is_of_list) return;
        const bool is_by_id = asked_.id[0] != '\0';
        const auto index = static_cast<int16_t>(is_by_id ? -1 : static_cast<int>(asked_.index));
        return refuse(link, asked_.from, asked_.id, index, error_of(value.result));
    }
    const bool is_float = value.type == ParameterValue::Type::kFloat;
    mav::ParamValue message{
        .param_value = is_float ? value.float_value : std::bit_cast<float>(value.int_value),
        .param_count = value.count,
        .param_index = value.index,
        .param_type = static_cast<uint8_t>(is_float ? mav::mav_param_type::kReal32
                                                    : mav::mav_param_type::kInt32)};
    if (value.index == kNoIndex) message.param_type = mav::mav_param_type::kUint32;  // the hash
    for (std::size_t i = 0; i < message.param_id.size(); ++i) {
        message.param_id[i] = static_cast<char>(value.id[i]);
    }
    link.send(message);
}

void ParameterTransfer::end(const ParameterValue& value) {
    asked_.is_one = false;
    if (!asked_.is_of_list) return;
    uint16_t& next = list_next_[asked_.line];
    if (next != asked_.index) return;  // begun again, or stopped
    ++next;
    if (next >= value.count) next = kNoList;
}

}  // namespace stator::apps::mavlink

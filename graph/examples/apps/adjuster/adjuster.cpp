#include "adjuster.hpp"

#include <algorithm>
#include <string_view>

namespace stator::apps::adjuster {

// Before the first answer it asks for what the value is.
void Adjuster::step(AdjusterPorts& ports) {
    const bool knows = static_cast<bool>(ports.answer);
    ports.request.publish([&] {
        using Action = ParameterRequest::Action;
        ParameterRequest request{.action = knows ? Action::kSet : Action::kGet,
                                 .type = ParameterRequest::Type::kInt32,
                                 .int_value = knows ? ports.answer->int_value + 1 : 0};
        std::ranges::copy(std::string_view("counter.first"), request.name.begin());
        return request;
    });
}

}  // namespace stator::apps::adjuster

// SPDX-License-Identifier: Apache-2.0
#include "web/server/message.hpp"

#include "acquisition/json_text.hpp"

namespace cmm::web {

Response refusal(int status, std::string_view why) {
    Response response;
    response.status = status;
    response.body = "{" + acquisition::JsonFields().add("error", why).text() + "}\n";
    return response;
}

}  // namespace cmm::web

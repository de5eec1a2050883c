#pragma once

#include <cctype>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace bipot {

/// What is wrong with a piece of XML or a page, empty when nothing: tags that do not match, a second
/// root, a bare
/// & or <, an attribute without quotes or twice in a tag. Of pages, some tags need no end, and
/// style and script are not read.
inline std::string markup_defect(std::string_view xml) {
  std::vector<std::string> open;
  bool rooted = false;
  for (std::size_t i = 0; i < xml.size();) {
    if (xml[i] == '&') {
      const std::size_t end = xml.find(';', i);
      const std::string_view name = xml.substr(i, end == xml.npos ? 1 : end - i + 1);
      if (name != "&amp;" && name != "&lt;" && name != "&gt;" && name != "&quot;") {
        return "bare & in " + std::string(xml.substr(i, 20));
      }
      ++i;
      continue;
    }
    if (xml[i] != '<') {
      ++i;
      continue;
    }
    if (xml.substr(i, 2) == "<?") {
      i = xml.find("?>", i) + 2;
      continue;
    }
    if (xml.substr(i, 9) == "<!DOCTYPE") {
      i = xml.find('>', i) + 1;
      continue;
    }
    const bool closing = xml[i + 1] == '/';
    std::size_t at = i + (closing ? 2 : 1);
    const std::size_t name_end = xml.find_first_of(" \t\n/>", at);
    const std::string name(xml.substr(at, name_end - at));
    if (name.empty() || std::isalpha(static_cast<unsigned char>(name[0])) == 0) {
      return "bare < in " + std::string(xml.substr(i, 20));
    }
    at = name_end;
    std::set<std::string> attributes;
    bool alone = std::set<std::string>{"meta", "link", "br", "input", "img"}.contains(name);
    for (;;) {
      at = xml.find_first_not_of(" \t\n", at);
      if (at == xml.npos) return "unfinished tag " + name;
      if (xml[at] == '>') break;
      if (xml[at] == '/') {
        alone = true;
        ++at;
        continue;
      }
      const std::size_t equals = xml.find('=', at);
      const std::string attribute(xml.substr(at, equals - at));
      if (equals == xml.npos || attribute.find_first_of("<>\"' ") != attribute.npos) {
        return "attribute of " + name + ": " + attribute;
      }
      if (!attributes.insert(attribute).second) return "twice in " + name + ": " + attribute;
      const char quote = xml[equals + 1];
      if (quote != '"' && quote != '\'') return "no quote in " + name;
      const std::size_t end = xml.find(quote, equals + 2);
      if (end == xml.npos || xml.substr(equals, end - equals).find('<') != xml.npos) {
        return "value of " + attribute + " in " + name;
      }
      at = end + 1;
    }
    i = at + 1;
    if (!closing && (name == "style" || name == "script")) i = xml.find("</" + name, i);
    if (closing) {
      if (open.empty() || open.back() != name) return "closes " + name;
      open.pop_back();
    } else {
      if (open.empty() && rooted) return "a second root: " + name;
      rooted = true;
      if (!alone) open.push_back(name);
    }
  }
  return open.empty() ? "" : "never closed: " + open.back();
}

}  // namespace bipot

// Making and updating nodes. Strings only ever become text or attribute values, never markup:
// names come from files.

const SVG = "http://www.w3.org/2000/svg";

function build(node, attributes, children) {
  set(node, attributes);
  node.append(...children.filter((child) => child !== null));
  return node;
}

/** An HTML element; a null attribute is left out. */
export const html = (tag, attributes = {}, ...children) =>
  build(document.createElement(tag), attributes, children);

/** An SVG element. */
export const svg = (tag, attributes = {}, ...children) =>
  build(document.createElementNS(SVG, tag), attributes, children);

/** Sets the attributes that differ; null removes one. */
export function set(node, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null) node.removeAttribute(name);
    else if (node.getAttribute(name) !== String(value)) node.setAttribute(name, value);
  }
}

/** Sets a node's text if it differs, so that an unchanged page is not laid out again. */
export function say(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/**
 * Makes the children of `parent` match `rows` in number and order: a row that is new is made by
 * `create(row)`, one that is gone is removed, and `update(node, row)` is called for every row.
 */
export function reconcile(parent, rows, create, update) {
  parent.rows ??= new Map();
  const before = parent.rows;
  parent.rows = new Map();
  let place = parent.firstChild;
  for (const row of rows) {
    const node = before.get(row.id) ?? create(row);
    before.delete(row.id);
    parent.rows.set(row.id, node);
    if (node === place) place = place.nextSibling;
    else parent.insertBefore(node, place);
    update(node, row);
  }
  for (const node of before.values()) node.remove();
}

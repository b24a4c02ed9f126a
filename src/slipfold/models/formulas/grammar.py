"""The grammar of formulas: text becomes a tree, or a message about a place in the text.

Nothing is evaluated. From the loosest to the tightest binding::

    formula  = formula ("+" | "-") formula        from the left
             | formula ("*" | "/") formula        from the left
             | ("-" | "+") formula                so that -q^2 is -(q^2)
             | formula "^" formula                from the right, and 2^-3 is 2^(-3)
             | number | name | name "(" formula ("," formula)* ")" | "(" formula ")"
    number   = 2, 2.5, .5, 1e-3
    name     = a letter or _, then letters, digits and _
"""

from __future__ import annotations

from slipfold.models.formulas.functions import FUNCTIONS, explain_unknown_function
from slipfold.models.formulas.tokens import FormulaError, Token, split_formula
from slipfold.models.formulas.tree import (
    BINDING,
    SIGN,
    Binary,
    Call,
    Name,
    Negative,
    Number,
    Tree,
    format_tree,
)

DEEPEST = 60
"""Nested parentheses, signs and powers: what people write stays below ten."""


def parse_formula(text: str) -> Tree:
    """Read a formula.

    >>> from slipfold.models.formulas.tree import format_tree
    >>> format_tree(parse_formula("-(q)^2 + 2 * (a*b)"))
    '-q^2 + 2*(a*b)'
    """
    parser = _Parser(split_formula(text))
    if parser.next.kind == "end":
        raise FormulaError("the formula is empty; give at least a number, e.g. 0", 0)
    tree = parser.formula(0)
    if parser.next.kind != "end":
        raise parser.unexpected()
    return tree


class _Parser:
    """Operator precedence parsing (Pratt): one function for all binary operators."""

    def __init__(self, tokens: list[Token]) -> None:
        self._tokens = tokens
        self._index = 0
        self._depth = 0

    @property
    def next(self) -> Token:
        return self._tokens[self._index]

    def _take(self) -> Token:
        token = self.next
        # Behind the last token there is nothing to take.
        self._index = min(self._index + 1, len(self._tokens) - 1)
        return token

    def formula(self, least: int) -> Tree:
        """Read operands and the operators that bind at least as tightly as `least`."""
        self._depth += 1
        if self._depth > DEEPEST:
            raise FormulaError(
                f"the formula is nested more than {DEEPEST} deep here; name parts of it in the "
                "table [formulas]",
                self.next.place,
            )
        tree = self._operand()
        while (binding := self._operator()) >= max(least, 1):
            sign = self._take()
            # An equal operator to the right belongs to the right operand only for powers.
            right = self.formula(binding if sign.text == "^" else binding + 1)
            tree = Binary(sign.text, tree, right, sign.place)
        self._depth -= 1
        return tree

    def _operator(self) -> int:
        return BINDING.get(self.next.text, 0) if self.next.kind == "sign" else 0

    def _operand(self) -> Tree:
        token = self._take()
        if token.kind == "number":
            return Number(float(token.text))
        if token.kind == "name":
            follows = self.next.kind == "sign" and self.next.text == "("
            return self._call(token) if follows else Name(token.text, token.place)
        if token.text == "-":
            return Negative(self.formula(SIGN))
        if token.text == "+":
            return self.formula(SIGN)
        if token.text == "(":
            tree = self.formula(0)
            self._close(token)
            return tree
        raise self._missing_operand(token)

    def _call(self, name: Token) -> Call:
        opening = self._take()
        arguments = []
        if self.next.text != ")":
            arguments.append(self.formula(0))
            while self.next.text == ",":
                self._take()
                arguments.append(self.formula(0))
        self._close(opening)
        if name.text not in FUNCTIONS:
            raise FormulaError(_unknown(name.text, arguments), name.place, len(name.text))
        count = FUNCTIONS[name.text].count
        if len(arguments) != count:
            wanted = "1 argument" if count == 1 else f"{count} arguments"
            form = "(y, x)" if count == 2 else "(x)"
            raise FormulaError(
                f"{name.text} takes {wanted}, not {len(arguments)}; write {name.text}{form}",
                name.place,
                len(name.text),
            )
        return Call(name.text, tuple(arguments), name.place)

    def _close(self, opening: Token) -> None:
        if self.next.text == ")":
            self._take()
        elif self.next.kind == "end":
            raise FormulaError(
                "this parenthesis is never closed; add a ) where it ends", opening.place
            )
        else:
            raise self.unexpected()

    def unexpected(self) -> FormulaError:
        """What to say about a token that cannot follow an operand."""
        token = self.next
        if token.text == ")":
            return FormulaError(
                "this parenthesis was never opened; leave it out or add a ( before", token.place
            )
        if token.text == ",":
            return FormulaError(
                "a comma stands between arguments of a function only; numbers have a point, e.g. "
                "0.5",
                token.place,
            )
        before = self._tokens[self._index - 1].text
        return FormulaError(
            f"there is no operator between {before[-20:]} and {token.text[:20]}; for a product "
            f"write {before[-20:]}*{token.text[:20]}",
            token.place,
            len(token.text),
        )

    def _missing_operand(self, token: Token) -> FormulaError:
        found = "the formula ends" if token.kind == "end" else f"{token.text!r} stands"
        return FormulaError(
            f"{found} where a number, a name or a parenthesis should; complete the formula",
            token.place,
            max(len(token.text), 1),
        )


def _unknown(name: str, arguments: list[Tree]) -> str:
    """Return the sentence about a function that there is not, as if a state is taken at a time."""
    time = arguments[0] if len(arguments) == 1 else None
    if isinstance(time, Binary) and time.operator == "-" and time.left == Name("t"):
        return f"{name}({format_tree(time)}) is a state at another time; delays are not supported"
    if isinstance(time, Number):
        return (
            f"{explain_unknown_function(name)}; if {name} is a state, its value at one time "
            "belongs to a boundary-value problem, and these are not supported"
        )
    return explain_unknown_function(name)

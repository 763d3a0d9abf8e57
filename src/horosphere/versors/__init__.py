"""Versors [Humanoid, section IV]: reflector, translator, rotor, motor; `@` composes them and moves entities."""

from ._motor import Motor as Motor
from ._reflector import Reflector as Reflector
from ._rotor import Rotor as Rotor
from ._translator import Translator as Translator
from ._versor import Versor as Versor

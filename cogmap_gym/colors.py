"""The colours of every picture: those of Okabe and Ito, told apart by colour-blind readers."""

from __future__ import annotations

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILLION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
ASR_COLORS = (SKY, ORANGE, PURPLE, YELLOW, BLUE, "#999999", GREEN, VERMILLION)
WALL, LIGHT_WALL = "#4D4D4D", "#C4C4C4"
FURNITURE, LIGHT_FURNITURE = "#D9D9D9", "#F0F0F0"
ROOM_NAME = "#7F7F7F"

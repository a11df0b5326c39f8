"""Recordings of one arm in several poses, as complex spectra with their noise.

In comes a folder with `campaign.yaml`; out go records on one grid, the known motion of the
joints, and the spectra that model and measurement are compared on.
"""

from model_gap.campaign.campaign import Campaign, GapRecord
from model_gap.campaign.campaign_file import CampaignEntry, read_campaign_file
from model_gap.campaign.copies import refuse_copies
from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.campaign.flat_tops import flat_topped
from model_gap.campaign.read_campaign import campaign_layout, read_campaign
from model_gap.campaign.resample import at_times
from model_gap.campaign.spectra import (
    Band,
    Complex,
    hann,
    HANN_POWER,
    record_spectra,
    RecordSpectra,
    smoothed,
    tail_of,
)
from model_gap.campaign.thresholds import CAMPAIGN
from model_gap.campaign.travel import standing, Travel, travel_of
from model_gap.campaign.weighting import Rows, Weighting

__all__ = [
    'CAMPAIGN',
    'HANN_POWER',
    'Band',
    'Campaign',
    'CampaignEntry',
    'Complex',
    'GapRecord',
    'RecordSpectra',
    'Rows',
    'Travel',
    'Weighting',
    'at_times',
    'campaign_layout',
    'explicit_damping',
    'flat_topped',
    'hann',
    'read_campaign',
    'read_campaign_file',
    'record_spectra',
    'refuse_copies',
    'smoothed',
    'standing',
    'tail_of',
    'travel_of',
]

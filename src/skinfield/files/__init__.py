"""Files: recordings, layouts, results and tables; a file has its name once it is whole."""

from skinfield.estimate.contact_table import rows_from_estimate as rows_from_estimate
from skinfield.files.fields import open_fields as open_fields
from skinfield.files.fields import write_fields as write_fields
from skinfield.files.mcap.live import LiveRecording as LiveRecording
from skinfield.files.pending import write_summary as write_summary
from skinfield.files.read import read as read
from skinfield.files.recordings.archive import save_recording as save_recording
from skinfield.files.recordings.matching import readings_for as readings_for
from skinfield.files.recordings.open import open_recording as open_recording
from skinfield.files.recordings.open import stream_recording as stream_recording
from skinfield.files.results import ResultsWriter as ResultsWriter
from skinfield.files.results import load_contacts as load_contacts
from skinfield.files.results import open_results as open_results
from skinfield.files.results import save_results as save_results
from skinfield.files.tables import open_contacts as open_contacts
from skinfield.files.tables import write_contacts as write_contacts
